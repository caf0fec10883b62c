//! Snapshots that are cut off, go on, expand without end or are damaged.

use glam::DVec3;
use potamoi_fields::Field as _;
use potamoi_fields::algorithms::ngp::Ngp;
use proptest::prelude::*;

use super::{at, fixture, load, patched};

/// Bytes after the packed stream, whose checksum is right.
#[test]
fn bytes_behind_the_packed_document_are_refused() {
    let mut bytes = std::fs::read(fixture("cube.ingp")).unwrap();
    assert!(load(&bytes).is_ok());
    bytes.push(0);
    let error = load(&bytes).unwrap_err();
    assert!(
        error.contains("bytes follow the end of the packed document"),
        "{error}"
    );
}

/// A small file that expands without end is refused where a model of its length
/// would have ended.
#[test]
fn a_file_that_expands_too_far_is_refused() {
    use std::io::Write as _;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bomb.ingp");
    let mut out = flate2::write::ZlibEncoder::new(
        std::fs::File::create(&path).unwrap(),
        flate2::Compression::fast(),
    );
    // A map of one text that claims 200 MB, all of which come.
    out.write_all(b"\x81\xa1x\xdb\x0b\xeb\xc2\x00").unwrap();
    for _ in 0..200 {
        out.write_all(&[b'a'; 1_000_000]).unwrap();
    }
    out.finish().unwrap();
    assert!(path.metadata().unwrap().len() < 1_000_000);
    let error = Ngp::load(&path).unwrap_err().to_string();
    assert!(
        error.contains("expands to more than 67108864 bytes"),
        "{error}"
    );
}

/// A file that ends early is refused, also where all but its checksum came; so is
/// what goes on after the document.
#[test]
fn the_file_ends_where_the_document_does() {
    let whole = std::fs::read(fixture("cube.ingp")).unwrap();
    for missing in 1..=8 {
        let error = load(&whole[..whole.len() - missing]).unwrap_err();
        assert!(error.contains("expected"), "{missing}: {error}");
    }
    let mut other = whole.clone();
    *other.last_mut().unwrap() ^= 1;
    assert!(load(&other).is_err(), "another checksum");
    let plain = patched(|_| {});
    load(&plain).unwrap();
    let error = load(&[&plain[..], b"\xc0"].concat()).unwrap_err();
    assert!(error.contains("bytes follow the end"), "{error}");
}

/// Lengths that a header claims cost nothing until the bytes come.
#[test]
fn claimed_lengths_take_no_memory() {
    for tail in [
        // A map, a list, binary data and a text of 2^32 - 1.
        &b"\xdf\xff\xff\xff\xff"[..],
        b"\x81\xa1x\xdd\xff\xff\xff\xff",
        b"\x81\xa8snapshot\x81\xadparams_binary\xc6\xff\xff\xff\xff\x00",
        b"\x81\xa8encoding\x81\xa5otype\xdb\xff\xff\xff\xffHash",
    ] {
        assert!(load(tail).unwrap_err().contains("field"));
    }
    // Nested deeper than is followed.
    let deep = [&b"\x81\xa1x"[..], &[0x91; 100_000]].concat();
    assert!(load(&deep).unwrap_err().contains("field"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// Bytes changed or cut anywhere, the numbers aside, are refused or load
    /// as some model; nothing panics.
    #[test]
    fn damaged_documents_do_not_panic(
        places in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
        whole in any::<bool>(),
    ) {
        let mut bytes = patched(|document| {
            *at(document, "snapshot.density_grid_binary") = rmpv::Value::Binary(vec![]);
            *at(document, "snapshot.params_binary") = rmpv::Value::Binary(vec![0; 40]);
        });
        prop_assert!(bytes.len() < 2000);
        for (place, byte) in places {
            let place = place.index(bytes.len());
            bytes[place] = byte;
        }
        if !whole {
            bytes.truncate(cut.index(bytes.len()));
        }
        prop_assert!(load(&bytes).is_err(), "40 bytes are too few parameters");
    }

    /// Compressed bytes changed anywhere.
    #[test]
    fn damaged_files_do_not_panic(place in any::<prop::sample::Index>(), byte: u8, cut: bool) {
        let mut bytes = std::fs::read(fixture("cube.ingp")).unwrap();
        let place = place.index(bytes.len());
        bytes[place] = byte;
        if cut {
            bytes.truncate(place);
            prop_assert!(load(&bytes).is_err());
        } else if let Ok(field) = load(&bytes) {
            let mut places = vec![DVec3::ZERO; field.tables().len()];
            field.index(DVec3::ZERO, &mut places);
        }
    }
}
