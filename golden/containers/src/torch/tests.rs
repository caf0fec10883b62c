#![allow(clippy::unwrap_used, clippy::panic)]

use std::io::Write as _;

use half::f16;
use proptest::prelude::*;
use zip::CompressionMethod;
use zip::write::{SimpleFileOptions, ZipWriter};

use super::*;

/// A pickle by hand: `{"a": {"t": tensor, "n": 3, "f": 0.5, "l": [1, 2.5]}}`,
/// the tensor transposed in its strides.
fn described() -> Vec<u8> {
    let mut p = vec![0x80, 2, b'}', b'q', 0];
    let text = |p: &mut Vec<u8>, t: &str| {
        p.push(b'X');
        p.extend((t.len() as u32).to_le_bytes());
        p.extend(t.as_bytes());
    };
    text(&mut p, "a");
    p.extend([b'}', b'q', 1, b'(']);
    text(&mut p, "t");
    p.extend(b"ctorch._utils\n_rebuild_tensor_v2\n((");
    text(&mut p, "storage");
    p.extend(b"ctorch\nHalfStorage\n");
    text(&mut p, "0");
    text(&mut p, "cpu");
    p.extend([
        b'K', 6, b't', b'Q', b'K', 0, b'K', 2, b'K', 3, 0x86, b'K', 1, b'K', 2, 0x86,
    ]);
    p.push(0x89);
    p.extend(b"ccollections\nOrderedDict\n)RtR");
    text(&mut p, "n");
    p.extend([b'K', 3]);
    text(&mut p, "f");
    p.push(b'G');
    p.extend(0.5f64.to_be_bytes());
    text(&mut p, "l");
    p.extend([b']', b'(', b'K', 1, b'G']);
    p.extend(2.5f64.to_be_bytes());
    p.extend(b"eus.");
    p
}

fn packed(pickle: &[u8], numbers: &[u8], method: CompressionMethod) -> tempfile::NamedTempFile {
    archived(&[("m/data.pkl", pickle), ("m/data/0", numbers)], method)
}

fn archived(members: &[(&str, &[u8])], method: CompressionMethod) -> tempfile::NamedTempFile {
    let file = tempfile::NamedTempFile::new().unwrap();
    let mut zip = ZipWriter::new(file.reopen().unwrap());
    let options = SimpleFileOptions::default().compression_method(method);
    for (name, bytes) in members {
        zip.start_file(*name, options).unwrap();
        zip.write_all(bytes).unwrap();
    }
    zip.finish().unwrap();
    file
}

static OPEN: Format = Format {
    name: "open",
    files: "",
    keys: &[],
    others: Fate::Listed,
};

/// What no tensor needs is listed, and two descriptions are refused.
#[test]
fn what_stands_beside_the_numbers_is_listed() {
    let (pickle, plain) = (described(), numbers());
    let longer = [&plain[..], &[0; 3]].concat();
    let own = [
        ("m/data.pkl", &pickle[..]),
        ("m/data/0", &longer),
        ("m/version", b"3"),
    ];
    let known = [&own[..], &[("m/byteorder", b"little")]].concat();
    let file = archived(&known, CompressionMethod::Stored);
    let listed = |path: &Path| {
        let mut found = Checkpoint::open(path).unwrap();
        found.tensor(&["a", "t"]).unwrap();
        let mut notes = Notes::default();
        found.finish(&OPEN, &mut notes).unwrap();
        notes.not_used().to_vec()
    };
    let told = "bytes after the numbers of m/data/0 (3)";
    let keys = listed(file.path());
    assert!(keys.iter().any(|key| key == told), "{keys:?}");
    assert!(!keys.iter().any(|key| key.contains("member")), "{keys:?}");
    let more = [&own[..], &[("m/data/1", b"12"), ("other", b"")]].concat();
    let file = archived(&more, CompressionMethod::Stored);
    let mut bytes = std::fs::read(file.path()).unwrap();
    bytes.extend(b"tail");
    std::fs::write(file.path(), bytes).unwrap();
    let keys = listed(file.path());
    for expected in [
        "bytes after the archive (4)",
        "member m/data/1",
        "member other",
    ] {
        assert!(keys.iter().any(|key| key == expected), "{keys:?}");
    }
    let two = [&own[..], &[("n/data.pkl", &pickle[..])]].concat();
    let file = archived(&two, CompressionMethod::Stored);
    let said = Checkpoint::open(file.path()).unwrap_err().to_string();
    assert!(said.contains("two members data.pkl"), "{said}");
}

#[test]
fn numbers_of_the_other_byte_order_are_refused() {
    let (pickle, numbers) = (described(), numbers());
    let members = [
        ("m/data.pkl", &pickle[..]),
        ("m/data/0", &numbers),
        ("m/byteorder", b"big"),
    ];
    let file = archived(&members, CompressionMethod::Stored);
    let said = Checkpoint::open(file.path()).unwrap_err().to_string();
    assert!(said.contains("numbers in byte order `big`"), "{said}");
}

fn numbers() -> Vec<u8> {
    let values = [1.0, 2.0, 3.0, 4.0, 5.0, -6.5].map(f16::from_f32);
    values
        .iter()
        .flat_map(|v| v.to_bits().to_le_bytes())
        .collect()
}

fn open(pickle: &[u8], numbers: &[u8]) -> Result<Checkpoint, TorchError> {
    Checkpoint::open(packed(pickle, numbers, CompressionMethod::Stored).path())
}

#[test]
fn tensors_follow_their_strides() {
    let file = packed(&described(), &numbers(), CompressionMethod::Stored);
    let mut found = Checkpoint::open(file.path()).unwrap();
    let tensor = found.tensor(&["a", "t"]).unwrap();
    assert_eq!(tensor.shape, [2, 3]);
    assert_eq!(tensor.values, [1.0, 3.0, 5.0, 2.0, 4.0, -6.5]);
    assert_eq!(found.number(&["a", "n"]).unwrap(), 3.0);
    assert_eq!(found.number(&["a", "f"]).unwrap(), 0.5);
    assert_eq!(found.numbers(&["a", "l"]).unwrap(), [1.0, 2.5]);
    assert!(found.has(&["a", "t"]) && !found.has(&["a", "u"]) && !found.has(&["a", "t", "x"]));
}

#[test]
fn what_is_missing_is_named() {
    let file = packed(&described(), &numbers(), CompressionMethod::Stored);
    let mut found = Checkpoint::open(file.path()).unwrap();
    for (error, expected) in [
        (found.tensor(&["a", "x"]).unwrap_err(), "`a/x` is missing"),
        (
            found.tensor(&["a", "n"]).unwrap_err(),
            "`a/n` is an integer",
        ),
        (found.tensor_of(&["a", "t"], &[3, 2]).unwrap_err(), "[3, 2]"),
        (found.number(&["a", "t"]).unwrap_err(), "one number"),
        (found.numbers(&["a", "n"]).unwrap_err(), "a list of numbers"),
    ] {
        let error = error.to_string();
        assert!(error.contains(expected), "{error}");
    }
    let short = packed(&described(), &numbers()[..10], CompressionMethod::Stored);
    let error = Checkpoint::open(short.path()).unwrap().tensor(&["a", "t"]);
    assert!(
        error
            .unwrap_err()
            .to_string()
            .contains("10 bytes in m/data/0")
    );
    let small = packed(&described(), &numbers(), CompressionMethod::Deflated);
    assert!(
        Checkpoint::open(small.path())
            .unwrap_err()
            .to_string()
            .contains("packed")
    );
}

/// A pickle that would run a command, one that is deep, and one whose shared
/// parts double with every two bytes: none is run, and none takes memory.
#[test]
fn hostile_pickles_are_refused() {
    let error = |pickle: &[u8]| open(pickle, &[]).unwrap_err().to_string();
    let run = error(b"\x80\x02cos\nsystem\nX\x02\x00\x00\x00ls\x85R.");
    assert!(
        run.contains("os.system") && run.contains("never run"),
        "{run}"
    );
    let mut deep = vec![0x80, 2, b')'];
    deep.resize(1 << 20, 0x85);
    assert!(error(&deep).contains("ends within a value"));
    let mut doubled = vec![0x80, 2, b')'];
    for _ in 0..100_000 {
        doubled.extend([b'q', 0, b'h', 0, 0x86]);
    }
    doubled.push(b'.');
    // It is a tuple, in which nothing is found.
    assert!(!open(&doubled, &[]).unwrap().has(&["a"]));
    // A text of a megabyte, made an array of bytes a thousand times.
    let mut copies = b"\x80\x02c_codecs\nencode\nq\x01X\x00\x00\x10\x00".to_vec();
    copies.resize(copies.len() + (1 << 20), b'a');
    copies.extend(b"X\x06\x00\x00\x00latin1\x86q\x00R");
    for _ in 0..1000 {
        copies.extend([b'h', 1, b'h', 0, b'R']);
    }
    assert!(error(&copies).contains("more bytes than the pickle has"));
    for (pickle, expected) in [
        (&b"\x80\x09."[..], "protocol 9"),
        (b"\x80\x02", "ends within"),
        (b"\x80\x02.", "a value is missing"),
        (b"\x80\x02h\x05.", "nothing was kept as 5"),
        (b"\x80\x02\x8a\xff", "ends within"),
        (b"\x80\x02Nt.", "a mark is missing"),
        (b"\x80\x02K\x01)R.", "an integer is called"),
        (b"\x80\x02\x99.", "opcode 0x99"),
    ] {
        let said = error(pickle);
        assert!(said.contains(expected), "{said}");
    }
}

#[test]
fn a_view_that_leaves_or_repeats_its_numbers_is_refused() {
    let good = described();
    let at = good
        .windows(6)
        .position(|w| w == [b'K', 2, b'K', 3, 0x86, b'K'])
        .unwrap();
    for (byte, value) in [(1, 4), (3, 200), (6, 9)] {
        let mut wrong = good.clone();
        wrong[at + byte] = value;
        let error = open(&wrong, &numbers()).unwrap().tensor(&["a", "t"]);
        let error = error.unwrap_err().to_string();
        assert!(error.contains("a view within its numbers"), "{error}");
    }
}

/// What PyTorch pickles of a storage on its own: by hand.
fn alone(count: u64, numbers: &[u8]) -> Vec<u8> {
    let mut p = b"\x80\x02\x8a\x0al\xfc\x9cF\xf9 j\xa8P\x19.\x80\x02M\xe9\x03.\x80\x02}.".to_vec();
    p.extend(b"\x80\x02(X\x07\x00\x00\x00storagectorch\nHalfStorage\nX\x01\x00\x00\x009");
    p.extend(b"X\x03\x00\x00\x00cpuK\x06NtQ.\x80\x02]X\x01\x00\x00\x009a.");
    p.extend(count.to_le_bytes());
    p.extend(numbers);
    p
}

/// An array of one dictionary with a tensor of these bytes, `twice` of them.
fn objects(alone: &[u8], twice: bool) -> Vec<u8> {
    let mut p =
        b"\x80\x03cnumpy.core.multiarray\n_reconstruct\ncnumpy\nndarray\nK\x00\x85".to_vec();
    p.extend(b"C\x01b\x87R(K\x01)cnumpy\ndtype\nX\x02\x00\x00\x00O8\x89\x88\x87R\x89]}(");
    for name in ["t", "u"].into_iter().take(1 + usize::from(twice)) {
        p.extend(b"X\x01\x00\x00\x00");
        p.extend(name.as_bytes());
        p.extend(b"ctorch._utils\n_rebuild_tensor_v2\n(");
        p.extend(b"ctorch.storage\n_load_from_bytes\n");
        if name == "t" {
            p.push(b'B');
            p.extend((alone.len() as u32).to_le_bytes());
            p.extend(alone);
            p.extend(b"q\x07");
        } else {
            p.extend(b"h\x07");
        }
        p.extend(b"\x85RK\x00K\x02K\x03\x86K\x01K\x02\x86\x89NtR");
    }
    p.extend(b"uatb.");
    p
}

#[test]
fn tensors_within_an_array_of_objects_are_read() {
    let path = Path::new("f");
    let read = |pickle: &[u8]| Checkpoint::of_object_array(path, pickle);
    let mut found = read(&objects(&alone(6, &numbers()), false)).unwrap();
    let tensor = found.tensor_of(&["t"], &[2, 3]).unwrap();
    assert_eq!(tensor.values, [1.0, 3.0, 5.0, 2.0, 4.0, -6.5]);
    let mut headless = alone(6, &numbers());
    headless[5] ^= 1;
    let large = alone(6, &[numbers(), vec![0; 1000]].concat());
    for (pickle, expected) in [
        (
            objects(&alone(7, &numbers()), false),
            "6 numbers with 12 bytes",
        ),
        (
            objects(&alone(6, &numbers()[..11]), false),
            "6 numbers with 11 bytes",
        ),
        (objects(&alone(6, &[])[..80], false), "pickle, byte"),
        (objects(&headless, false), "without the head"),
        (objects(&large, true), "more bytes than the pickle has"),
        (b"\x80\x02}.".to_vec(), "a dictionary instead of an array"),
    ] {
        let error = read(&pickle).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    // A storage whose description is a storage again.
    let mut nested = alone(6, &[])[..21].to_vec();
    nested.extend(b"\x80\x02}.\x80\x02ctorch.storage\n_load_from_bytes\nC\x00\x85R.");
    let error = read(&objects(&nested, false)).unwrap_err().to_string();
    assert!(error.contains("storages within storages"), "{error}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn damage_to_an_array_of_objects_is_never_a_panic(
        at in any::<prop::sample::Index>(), byte: u8, cut: bool,
    ) {
        let mut pickle = objects(&alone(6, &numbers()), true);
        let at = at.index(pickle.len());
        if cut {
            pickle.truncate(at);
        } else {
            pickle[at] = byte;
        }
        if let Ok(mut found) = Checkpoint::of_object_array(Path::new("f"), &pickle) {
            let _ = found.tensor(&["t"]);
        }
    }

    #[test]
    fn damage_is_never_a_panic(at in any::<prop::sample::Index>(), byte: u8, cut: bool) {
        let mut pickle = described();
        let at = at.index(pickle.len());
        if cut {
            pickle.truncate(at);
        } else {
            pickle[at] = byte;
        }
        if let Ok(mut found) = open(&pickle, &numbers()) {
            let _ = found.tensor(&["a", "t"]);
            let _ = found.number(&["a", "n"]);
            let _ = found.numbers(&["a", "l"]);
        }
    }
}
