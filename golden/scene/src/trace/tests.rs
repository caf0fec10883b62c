#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;
use std::io::{Cursor, Read as _, Write as _};
use std::path::Path;

use proptest::prelude::*;
use zip::write::{SimpleFileOptions, ZipWriter};

use super::*;
use potamoi_reference::Units as _;

fn small(name: &str, limits: Limits) -> Trace {
    let mut scene = crate::tests::opened(name);
    scene.set_size(Some(16), Some(16)).unwrap();
    Trace::record(&scene, &Config::paper(), limits).unwrap()
}

#[test]
fn what_was_written_is_read_back_and_the_same_bytes_come_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.npz");
    for name in ["garden", "lantern"] {
        let trace = small(name, Limits::NONE);
        assert!(trace.gathered.len() > 10 && trace.computed.len() > 10);
        trace.write(&path).unwrap();
        assert_eq!(Trace::read(&path, &Config::paper()).unwrap(), trace);
        let bytes = fs::read(&path).unwrap();
        small(name, Limits::NONE).write(&path).unwrap();
        assert_eq!(fs::read(&path).unwrap(), bytes);
        // Nothing is left beside it.
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}

/// Of samples that lie in several MVoxels, sums go through the unit: they are all kept.
#[test]
fn exact_sums_are_recorded_too() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("split.toml");
    let text = "[model]\nkind = \"builtin\"\nname = \"lantern\"\n[render]\nhalo = \"split\"\n";
    fs::write(&scene, text).unwrap();
    let mut scene = Scene::open(scene.to_str().unwrap()).unwrap();
    scene.set_size(Some(16), Some(16)).unwrap();
    let config = Config::from_toml("[gu]\nsums = \"exact\"\n", "test").unwrap();
    let trace = Trace::record(&scene, &config, Limits::NONE).unwrap();
    let mut twins = ReferenceUnits::new(&config);
    scene.render_fixed(&config, &mut twins).unwrap();
    let counts = twins.counts();
    let tasks: Vec<_> = trace.gathered.iter().map(|g| g.task.clone()).collect();
    let entries: u64 = tasks.iter().map(|t| t.entries.len() as u64).sum();
    assert!(entries > 100);
    assert_eq!(
        (tasks.len() as u64, entries),
        (counts.gathers, counts.feature_vectors)
    );
    let mut sums = vec![];
    twins.sums(&tasks, &mut sums).unwrap();
    let kept: Vec<i32> = trace
        .gathered
        .iter()
        .flat_map(|g| g.features.clone())
        .collect();
    assert_eq!(kept, sums);
    // What no code of 16 bits holds is among them.
    assert!(sums.iter().any(|sum| i16::try_from(*sum).is_err()));
    let path = folder.path().join("t.npz");
    trace.write(&path).unwrap();
    assert_eq!(Trace::read(&path, &config).unwrap(), trace);
    // One with codes says that it is of this configuration.
    let mut forged = small("lantern", Limits::NONE);
    forged.configuration = config.hash();
    forged.write(&path).unwrap();
    let error = Trace::read(&path, &config).unwrap_err().to_string();
    assert!(
        error.contains("array `gather_features`: expected `gather_sums`"),
        "{error}"
    );
}

#[test]
fn limits_hold() {
    let limits = Limits {
        entries: 200,
        elements: 5_000,
    };
    let trace = small("garden", limits);
    let entries: usize = trace.gathered.iter().map(|g| g.task.entries.len()).sum();
    let last = trace.gathered.last().unwrap().task.entries.len();
    assert!(entries >= 200 && entries - last < 200);
    let elements: usize = trace.computed.iter().map(|c| c.a.len()).sum();
    assert!(elements <= 5_000 && elements > 1_000);
}

/// A small trace and its bytes.
fn sample() -> (Trace, Vec<u8>) {
    let limits = Limits {
        entries: 50,
        elements: 2_000,
    };
    let trace = small("lantern", limits);
    let bytes = trace.pack().unwrap();
    (trace, bytes)
}

fn read(bytes: &[u8]) -> Result<Trace, TraceError> {
    Trace::unpack(Path::new("t.npz"), bytes)
}

/// The members of a file, changed, packed anew.
fn repacked(bytes: &[u8], change: impl FnOnce(&mut Vec<(String, Vec<u8>)>)) -> Vec<u8> {
    let mut archive = ZipArchive::new(bytes);
    let mut members = archive.members();
    change(&mut members);
    let mut zip = ZipWriter::new(Cursor::new(vec![]));
    for (name, bytes) in members {
        zip.start_file(name, SimpleFileOptions::default()).unwrap();
        zip.write_all(&bytes).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

#[test]
fn what_stands_around_the_archive_is_refused() {
    let bytes = sample().1;
    for (file, expected) in [
        (
            [&bytes[..], b"tail"].concat(),
            "bytes after the archive (4)",
        ),
        (
            [b"pre", &bytes[..]].concat(),
            "bytes before the archive (3)",
        ),
    ] {
        let said = read(&file).unwrap_err().to_string();
        assert!(said.contains(expected), "{said}");
    }
}

struct ZipArchive<'a>(zip::ZipArchive<Cursor<&'a [u8]>>);

impl<'a> ZipArchive<'a> {
    fn new(bytes: &'a [u8]) -> Self {
        Self(zip::ZipArchive::new(Cursor::new(bytes)).unwrap())
    }

    fn members(&mut self) -> Vec<(String, Vec<u8>)> {
        (0..self.0.len())
            .map(|i| {
                let mut file = self.0.by_index(i).unwrap();
                let mut bytes = vec![];
                file.read_to_end(&mut bytes).unwrap();
                (file.name().to_owned(), bytes)
            })
            .collect()
    }
}

#[test]
fn a_changed_file_is_refused_by_the_arrays_name() {
    let (trace, bytes) = sample();
    assert_eq!(read(&bytes).unwrap(), trace);
    let refused = |bytes: &[u8], expected: &str| {
        let error = read(bytes).unwrap_err().to_string();
        assert!(
            error.contains(expected) && error.contains("t.npz"),
            "{error}"
        );
    };
    let names: Vec<String> = ZipArchive::new(&bytes)
        .members()
        .into_iter()
        .map(|(name, _)| name)
        .collect();
    assert_eq!(names.len(), 11);
    for i in 1..names.len() {
        let array = format!("array `{}`", names[i].trim_end_matches(".npy"));
        refused(&repacked(&bytes, |m| drop(m.remove(i))), &array);
        // One value changed, the file otherwise whole.
        let changed = repacked(&bytes, |m| *m[i].1.last_mut().unwrap() ^= 1);
        refused(&changed, &array);
        let cut = repacked(&bytes, |m| {
            m[i].1.pop();
        });
        refused(&cut, &array);
        if i > 1 {
            let swapped = repacked(&bytes, |m| m.swap(i, i - 1));
            let before = format!("array `{}`", names[i - 1].trim_end_matches(".npy"));
            refused(&swapped, &before);
            // Contents swapped under the right names.
            let crossed = repacked(&bytes, |m| {
                let other = std::mem::take(&mut m[i - 1].1);
                let own = std::mem::replace(&mut m[i].1, other);
                m[i - 1].1 = own;
            });
            refused(&crossed, "array `");
        }
    }
    let extra = repacked(&bytes, |m| m.push(("more.npy".to_owned(), vec![1])));
    refused(&extra, "array `more`");
    refused(&repacked(&bytes, |m| drop(m.remove(0))), "array `header`");
    let json = repacked(&bytes, |m| *m[0].1.last_mut().unwrap() = b'x');
    refused(&json, "array `header`");
    refused(b"", "t.npz");
    refused(b"not a zip file at all", "NPZ");
}

/// A type that is none is refused as such, before the array is unpacked.
#[test]
fn a_type_that_no_array_has_is_refused() {
    let bytes = repacked(&sample().1, |m| {
        let header = &mut m[0].1;
        let known = b"\"dtype\":\"<";
        let at = header.windows(known.len()).position(|w| w == known);
        header[at.unwrap() + known.len()] = b'x';
    });
    let error = read(&bytes).unwrap_err().to_string();
    assert!(error.contains("expected <i2, <u2, <i4 or <u4"), "{error}");
}

/// The sample, with another header of array `gather_rows` and a digest to fit.
fn forged(change: impl FnOnce(&str) -> String) -> Vec<u8> {
    let (_, bytes) = sample();
    repacked(&bytes, |m| {
        let text = String::from_utf8(m[2].1[10..128].to_vec()).unwrap();
        let header = change(text.trim_end());
        assert!(header.len() < 118);
        m[2].1[10..128].copy_from_slice(format!("{header:117}\n").as_bytes());
        let digest = blake3::hash(&m[2].1).to_hex().to_string();
        let header = String::from_utf8_lossy(&m[0].1[128..]).into_owned();
        let names = header.find("\"gather_rows\"").unwrap();
        let from = names + header[names..].find("\"digest\":\"").unwrap() + 10;
        m[0].1[128 + from..128 + from + 64].copy_from_slice(digest.as_bytes());
    })
}

/// Members whose own header claims more than there is, or another meaning.
#[test]
fn an_arrays_own_header_is_the_expected_one() {
    assert!(read(&forged(str::to_owned)).is_ok());
    let huge = |header: &str| {
        let at = header.find("'shape': (").unwrap() + 10;
        let end = at + header[at..].find(',').unwrap();
        format!(
            "{}{}{}",
            &header[..at],
            "9".repeat(end - at),
            &header[end..]
        )
    };
    let shape = |header: &str| {
        let at = header.find("'shape'").unwrap();
        header[at..].trim_end_matches([',', ' ', '}']).to_owned()
    };
    for bytes in [
        forged(huge),
        forged(|header| header.replace("False", "True")),
        forged(|header| header.replace("<i2", ">i2").replace("<u2", ">u2")),
        // The right words in the wrong place.
        forged(|header| {
            format!(
                "{{{}, 'descr': '<i8', {}}}",
                "'fortran_order': True",
                shape(header)
            )
        }),
    ] {
        let error = read(&bytes).unwrap_err().to_string();
        assert!(error.contains("array `gather_rows`"), "{error}");
        assert!(error.contains("shape"), "{error}");
    }
}

#[test]
fn another_configuration_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("t.npz");
    sample().0.write(&path).unwrap();
    let other = Config::from_toml("[gu]\nports = 4", "test").unwrap();
    let error = Trace::read(&path, &other).unwrap_err().to_string();
    let hashes = [Config::paper().hash(), other.hash()];
    assert!(hashes.iter().all(|h| error.contains(h)), "{error}");
    let error = Trace::read(&folder.path().join("no.npz"), &other).unwrap_err();
    assert!(error.to_string().contains("no.npz"), "{error}");
    let nowhere = sample().0.write(Path::new("no/such/folder/t.npz"));
    assert!(nowhere.unwrap_err().to_string().contains("no/such/folder"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Cut off or changed anywhere: an error or the very same trace, never a
    /// panic.
    #[test]
    fn damage_is_never_a_panic(at in any::<prop::sample::Index>(), bit in 0u8..8, cut: bool) {
        thread_local! {
            static SAMPLE: (Trace, Vec<u8>) = sample();
        }
        SAMPLE.with(|(trace, bytes)| {
            let mut bytes = bytes.clone();
            let at = at.index(bytes.len());
            if cut {
                bytes.truncate(at);
            } else {
                bytes[at] ^= 1 << bit;
            }
            if let Ok(found) = read(&bytes) {
                assert_eq!(&found, trace);
            }
        });
    }
}
