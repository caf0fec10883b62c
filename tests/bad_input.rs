//! What is wrong with an input is said once, clearly, and nothing is written.

use std::fs;
use std::path::Path;

use crate::common::{self, expect, potamoi, stderr};

/// Three Gaussians in front of the default camera.
fn ply(count: &str, properties: &[&str], rows: &[Vec<f32>]) -> Vec<u8> {
    let mut bytes =
        format!("ply\nformat binary_little_endian 1.0\nelement vertex {count}\n").into_bytes();
    for property in properties {
        bytes.extend(format!("property float {property}\n").bytes());
    }
    bytes.extend(b"end_header\n");
    for row in rows {
        for value in row {
            bytes.extend(value.to_le_bytes());
        }
    }
    bytes
}

const PROPERTIES: [&str; 14] = [
    "x", "y", "z", "f_dc_0", "f_dc_1", "f_dc_2", "opacity", "scale_0", "scale_1", "scale_2",
    "rot_0", "rot_1", "rot_2", "rot_3",
];

fn rows() -> Vec<Vec<f32>> {
    (0..3)
        .map(|i| {
            let i = i as f32;
            vec![
                0.3 * i,
                0.1,
                0.2 * i,
                0.5,
                0.2 * i,
                -0.1,
                2.0,
                -1.5,
                -2.0,
                -1.7,
                1.0,
                0.1,
                0.2,
                0.0,
            ]
        })
        .collect()
}

fn render(folder: &Path, code: i32, scene: &str) -> String {
    let said = expect(
        folder,
        code,
        &[
            "render", "--scene", scene, "--width", "32", "--out", "p.png",
        ],
    );
    assert_eq!(folder.join("p.png").exists(), code == 0, "{said}");
    said
}

#[test]
fn splat_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let good = ply("3", &PROPERTIES, &rows());
    let write = |bytes: &[u8]| fs::write(at.join("m.ply"), bytes).unwrap();
    write(&good);
    render(at, 0, "m.ply");
    let picture = fs::read(at.join("p.png")).unwrap();
    // Properties in another order are the same scene.
    let order: Vec<usize> = (0..14).rev().collect();
    let names: Vec<&str> = order.iter().map(|i| PROPERTIES[*i]).collect();
    let values: Vec<Vec<f32>> = rows()
        .iter()
        .map(|row| order.iter().map(|i| row[*i]).collect())
        .collect();
    write(&ply("3", &names, &values));
    render(at, 0, "m.ply");
    assert_eq!(fs::read(at.join("p.png")).unwrap(), picture);
    fs::remove_file(at.join("p.png")).unwrap();

    let refused = |bytes: &[u8], expected: &str| {
        write(bytes);
        let said = render(at, 2, "m.ply");
        assert!(said.contains("m.ply") && said.contains(expected), "{said}");
    };
    refused(&good[..good.len() - 7], "the file is cut off");
    refused(&good[..60], "no `end_header` line");
    refused(b"", "not a PLY file");
    refused(b"no PLY file\n\x00\x01\x02", "not a PLY file");
    refused(&ply("0", &PROPERTIES, &[]), "no Gaussian");
    refused(
        &ply("99999999999999999999", &PROPERTIES, &rows()),
        "element vertex",
    );
    refused(
        &ply("4000000000", &PROPERTIES, &rows()),
        "224000000000 bytes",
    );
    refused(&ply("3", &PROPERTIES[..13], &rows()), "rot_3");
    for (column, name) in [(0, "x"), (6, "opacity"), (8, "scale_1")] {
        for bad in [f32::NAN, f32::INFINITY] {
            // Infinite logits are opacities of 0 and 1.
            if name == "opacity" && bad.is_infinite() {
                continue;
            }
            let mut values = rows();
            values[1][column] = bad;
            refused(&ply("3", &PROPERTIES, &values), name);
        }
    }
    let mut huge = b"ply\nformat binary_little_endian 1.0\n".to_vec();
    for i in 0..300_000 {
        huge.extend(format!("comment {i} is a long line that says nothing at all\n").bytes());
    }
    refused(&huge, "within 16777216 bytes");
    write(&good);
}

/// Commands that need a tool are in tests/cases; the others say what is missing, or do without.
#[test]
fn missing_tools() {
    let folder = tempfile::tempdir().unwrap();
    let run = |arguments: &[&str]| {
        potamoi()
            .current_dir(folder.path())
            .env_clear()
            .env("PATH", folder.path())
            .env("HOME", folder.path())
            .args(arguments)
            .output()
            .unwrap()
    };
    let done = run(&["doctor"]);
    assert_eq!(done.status.code(), Some(3), "{}", stderr(&done));
    assert!(stderr(&done).contains("verilator"), "{}", stderr(&done));
    let done = run(&["verify", "--width", "16", "--engine", "interpreter"]);
    assert!(done.status.success(), "{}", stderr(&done));
}

/// Names of flags of the version before do the same, and a line says what they are called now.
#[test]
fn old_names_of_flags_work_with_a_note() {
    let grid = Path::new(env!("CARGO_MANIFEST_DIR")).join("synth/grid-asap7.json");
    let grid = grid.display();
    old_names_do_the_same(&[
        ("emit --out a".to_owned(), "emit --out-dir a".to_owned()),
        (
            format!("estimate --grid {grid} --unit gu"),
            format!("estimate --fit-to {grid} --unit gu"),
        ),
    ]);
}

#[test]
fn old_names_of_slower_commands_work_too() {
    let frames = "warp --scene lantern --width 12 --frames 3 --window 2 --frame-ms 20";
    let model = "model --scene lantern --width 12 --frames 2 --window 2";
    old_names_do_the_same(&[
        (
            format!("{frames} --out b --trace t.json"),
            format!("{frames} --out-dir b --chrome-trace t.json"),
        ),
        (
            format!("{model} --energy e.svg --roofline r.svg --trace t.json"),
            format!("{model} --plot-energy e.svg --plot-roofline r.svg --chrome-trace t.json"),
        ),
        ("cost --unit exp".to_owned(), "cost --study exp".to_owned()),
    ]);
}

/// Runs each command by its old name and by its new one.
fn old_names_do_the_same(pairs: &[(String, String)]) {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let said = |arguments: &str| {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        let done = common::run(at, &arguments);
        assert!(done.status.success(), "{}", stderr(&done));
        // Work that the other name has done is not done again.
        let printed = common::stdout(&done).replace("counted earlier", "counted now");
        (printed, stderr(&done))
    };
    for (old, new) in pairs {
        let ((printed, notes), (expected, quiet)) = (said(old), said(new));
        assert_eq!(printed, expected, "{old}");
        assert!(!quiet.contains("note: "), "{quiet}");
        let renamed: Vec<_> = new.split(' ').filter(|w| !old.contains(*w)).collect();
        let flags: Vec<_> = renamed.iter().filter(|w| w.starts_with("--")).collect();
        assert!(!flags.is_empty(), "{new}");
        for flag in flags {
            assert_eq!(
                notes.matches(&format!("is now {flag};")).count(),
                1,
                "{notes}"
            );
        }
    }
}
