//! Tests of the harness itself: it detects one faulty reader a structure.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use crate::frame::tree::Tree;
use crate::frame::{
    Files, Format, MEMORY, Rng, Verdict, flat, npy, pickle, ply, tally, text, tree, zips,
};
use crate::pictures::single;

fn format(
    name: &'static str,
    mutant: fn(&mut Rng) -> Vec<u8>,
    judge: fn(&Path) -> Verdict,
) -> Format {
    Format {
        name,
        binary: super::BINARY,
        whole: Arc::new(Files::new),
        mutant: Arc::new(move |rng| single("toy", mutant(rng))),
        judge,
    }
}

/// The message about a faulty reader, with the command that reproduces it.
fn fault(format: &Format, expected: &str) {
    let tally = tally(format, 0..300, false);
    let told = tally.faults.iter().any(|fault| {
        fault.contains(expected)
            && fault.contains("POTAMOI_MUTANT=")
            && fault.contains(&format!("cargo test {} {}", super::BINARY, format.name))
    });
    assert!(told, "{}: {:?}", format.name, tally.faults);
}

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).expect("a file")
}

/// A reader that accepts NaN in place of any number.
fn taken(nan: bool) -> Verdict {
    if nan {
        Verdict::Broken("a number is NaN".to_owned())
    } else {
        Verdict::Sound
    }
}

fn floats(bytes: &[u8]) -> bool {
    bytes
        .as_chunks::<4>()
        .0
        .iter()
        .any(|b| f32::from_le_bytes(*b).is_nan())
}

#[test]
fn readers_that_accept_nan_are_found_out() {
    let nan = "read, but a number is NaN";
    let json = format(
        "toy_json",
        |rng| tree::json(b"{\"a\": 1.5}", rng),
        |path| taken(String::from_utf8_lossy(&bytes(path)).contains("NaN")),
    );
    fault(&json, nan);
    let toml = format(
        "toy_toml",
        |rng| tree::toml("a = 1.5", rng),
        |path| {
            let text = String::from_utf8_lossy(&bytes(path)).into_owned();
            let table: toml::Table = text.parse().unwrap_or_default();
            taken(
                table
                    .get("a")
                    .and_then(toml::Value::as_float)
                    .is_some_and(f64::is_nan),
            )
        },
    );
    fault(&toml, nan);
    let messages = format(
        "toy_messages",
        |rng| {
            let mut tree = Tree::Map(vec![("a".to_owned(), Tree::Float(1.5))]);
            tree.mutate(rng);
            tree.messages()
        },
        |path| {
            let bytes = bytes(path);
            let value = rmpv::decode::read_value(&mut &*bytes).expect("it is whole");
            taken(value["a"].as_f64().is_some_and(f64::is_nan))
        },
    );
    fault(&messages, nan);
    let words = format(
        "toy_words",
        |rng| text::mutate("a 1.5 2.5\n", rng),
        |path| taken(String::from_utf8_lossy(&bytes(path)).contains("NaN")),
    );
    fault(&words, nan);
    let array = format(
        "toy_flat",
        |rng| {
            let mut bytes = vec![0; 64];
            flat::number(&mut bytes, flat::Kind::Float, rng);
            bytes
        },
        |path| taken(floats(&bytes(path))),
    );
    fault(&array, nan);
    const PLY: &[u8] = b"ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\nend_header\n\0\0\0\0\0\0\0\0";
    let ply = format(
        "toy_ply",
        |rng| ply::mutate(PLY, rng),
        |path| {
            let bytes = bytes(path);
            taken(bytes.len() > 8 && floats(&bytes[bytes.len() - 8..]))
        },
    );
    fault(&ply, nan);
    let npz = format(
        "toy_npz",
        |rng| {
            let mut own = b"\x93NUMPY\x01\0v\0".to_vec();
            let head = "{'descr': '<f4', 'fortran_order': False, 'shape': (2,), }";
            own.extend(format!("{head:117}\n").bytes());
            own.extend([0; 8]);
            npy::mutate(&mut own, rng);
            zips::packed(&single("a.npy", own), zip::CompressionMethod::Stored)
        },
        |path| {
            let members = zips::members(&bytes(path));
            taken(
                members
                    .iter()
                    .any(|(_, own)| own.len() == 136 && floats(&own[128..])),
            )
        },
    );
    fault(&npz, nan);
    let pickle = format(
        "toy_pickle",
        |rng| {
            let number = 1.5f64.to_be_bytes();
            let whole = [b"\x80\x02}(X\x01\0\0\0aG", &number[..], b"u."].concat();
            pickle::mutate(&whole, rng)
        },
        |path| {
            let bytes = bytes(path);
            let mut numbers = bytes.windows(9).filter(|w| w[0] == b'G');
            taken(numbers.any(|w| {
                f64::from_be_bytes([w[1], w[2], w[3], w[4], w[5], w[6], w[7], w[8]]).is_nan()
            }))
        },
    );
    fault(&pickle, nan);
}

#[test]
fn panics_memory_and_words_are_found_out() {
    const JSON: &[u8] = b"{\"count\": 3}";
    let mutant = |rng: &mut Rng| tree::json(JSON, rng);
    fault(
        &format("toy_panic", mutant, |path| {
            let value: serde_json::Value = serde_json::from_slice(&bytes(path)).unwrap_or_default();
            assert!(value["count"] != -1, "a negative count");
            Verdict::Sound
        }),
        "a panic",
    );
    fault(
        &format("toy_memory", mutant, |path| {
            let value: serde_json::Value = serde_json::from_slice(&bytes(path)).unwrap_or_default();
            let count = value["count"].as_u64().unwrap_or(0).min(1 << 29);
            let room: Vec<u8> = Vec::with_capacity(count as usize);
            taken(room.capacity() == 1)
        }),
        &format!("expected at most {MEMORY}"),
    );
    fault(
        &format("toy_words_of_a_library", mutant, |path| {
            #[derive(serde::Deserialize)]
            struct Toy {
                count: u32,
            }
            Verdict::of(
                serde_json::from_slice::<Toy>(&bytes(path))
                    .map_err(|e| format!("{}: {e}", path.display())),
                |toy| (toy.count < u32::MAX).then_some(()).ok_or_else(String::new),
            )
        }),
        "strange words",
    );
    fault(
        &format("toy_silent", mutant, |path| {
            Verdict::of(
                serde_json::from_slice::<serde_json::Value>(&bytes(path)),
                |_| Ok(()),
            )
        }),
        "no name of the file",
    );
    fault(
        &format("toy_loud", mutant, |path| {
            Verdict::Refused(format!("{}: {}", path.display(), "x".repeat(2000)))
        }),
        "characters",
    );
}

#[test]
fn a_reader_that_hangs_is_found_out() {
    let hangs = format(
        "toy_hang",
        |_| vec![],
        |_| {
            std::thread::sleep(Duration::from_secs(3600));
            Verdict::Sound
        },
    );
    let tally = crate::frame::tally_within(&hangs, 0..1, false, Duration::from_millis(50));
    assert!(tally.faults[0].contains("no answer in 50ms"), "{tally:?}");
}
