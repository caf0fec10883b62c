//! Damaged files yield an error or a valid cloud.

use proptest::prelude::*;
use proptest::sample::Index;

use super::pack::{archive, gunzip, gzip, members};
use super::*;

/// Bytes to overwrite with their positions, and a length to truncate to.
fn damage() -> impl Strategy<Value = (Vec<(Index, u8)>, Option<Index>)> {
    let writes = proptest::collection::vec((any::<Index>(), any::<u8>()), 0..6);
    (writes, proptest::option::weighted(0.3, any::<Index>()))
}

fn apply(bytes: &mut Vec<u8>, within: usize, damage: &(Vec<(Index, u8)>, Option<Index>)) {
    let within = within.min(bytes.len());
    for (at, byte) in &damage.0 {
        bytes[at.index(within)] = *byte;
    }
    if let Some(cut) = &damage.1 {
        bytes.truncate(cut.index(bytes.len()));
    }
}

/// Checks that a cloud is valid.
fn sane(read: Result<Cloud, FileError>) {
    match read {
        Ok(cloud) => assert!(cloud.len() <= 1 << 16),
        Err(e) => assert!(e.to_string().starts_with("f: "), "{e}"),
    }
}

proptest! {
    #[test]
    fn anywhere(which in 0..FIXTURES.len(), damage in damage()) {
        let (name, parse) = FIXTURES[which];
        let mut bytes = fixture(name);
        apply(&mut bytes, usize::MAX, &damage);
        sane(parse(&bytes, "f"));
    }

    #[test]
    fn headers(which in 0..FIXTURES.len(), damage in damage()) {
        let (name, parse) = FIXTURES[which];
        let mut bytes = fixture(name);
        apply(&mut bytes, 160, &damage);
        sane(parse(&bytes, "f"));
    }

    #[test]
    fn inside_a_gzip_stream(damage in damage(), header in any::<bool>()) {
        for name in ["cloud.v2.spz", "cloud.v3.spz"] {
            let mut bytes = gunzip(&fixture(name));
            apply(&mut bytes, if header { 16 } else { usize::MAX }, &damage);
            sane(spz_cloud(&gzip(&bytes), "f"));
        }
    }

    #[test]
    fn inside_an_archive(damage in damage(), member in any::<Index>(), header in any::<bool>()) {
        let mut members = members(&fixture("cloud.sog"));
        let member = member.index(members.len());
        apply(&mut members[member].1, if header { 64 } else { usize::MAX }, &damage);
        sane(sog_cloud(&archive(&members), "f"));
    }

    #[test]
    fn noise(bytes in proptest::collection::vec(any::<u8>(), 0..400)) {
        sane(splat_cloud(&bytes, "f"));
        for (name, parse) in FIXTURES {
            sane(parse(&bytes, "f"));
            let head = fixture(name);
            sane(parse(&[&head[..64], &bytes].concat(), "f"));
        }
    }

    #[test]
    fn no_cut_is_taken_for_a_whole_file(which in 0..FIXTURES.len(), at in any::<Index>()) {
        let (name, parse) = FIXTURES[which];
        let bytes = fixture(name);
        prop_assert!(parse(&bytes[..at.index(bytes.len())], "f").is_err());
    }
}
