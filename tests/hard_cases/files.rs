//! NaN and infinities in the place of each number of each input that holds numbers: refused by the
//! name of the file, or without effect on the picture's being one. Files whose contents are packed
//! and carry check sums have the same done to their contents in the tests beside their readers.

use std::fs;
use std::path::Path;

use potamoi_gaussians::files;
use potamoi_scene::Scene;
use potamoi_system::system_model::System;

use super::scenes::{cameras, write};
use potamoi_analysis::hard_cases::pictures::all;

/// What is put in the place of a number in text.
const ODD: [&str; 4] = ["nan", "inf", "-inf", "1e999"];

/// Where the numbers of a text are: what begins like one where a word begins.
fn numbers(text: &str) -> Vec<std::ops::Range<usize>> {
    let bytes = text.as_bytes();
    let part = |b: u8| b.is_ascii_alphanumeric() || b"+-._".contains(&b);
    let mut found = vec![];
    let mut at = 0;
    while at < bytes.len() {
        let from = at;
        while at < bytes.len() && part(bytes[at]) {
            at += 1;
        }
        if text[from..at].parse::<f64>().is_ok_and(f64::is_finite) {
            found.push(from..at);
        }
        at = at.max(from + 1);
    }
    found
}

/// Refused with the file's name, or a scene whose picture holds numbers.
fn refused(scene: &Path, file: &str, what: &str) -> bool {
    match Scene::open(scene.to_str().unwrap()) {
        Err(error) => {
            let said = error.to_string();
            assert!(said.contains(file), "{what}: {said}");
            true
        }
        Ok(mut scene) => {
            scene.set_size(Some(9), Some(7)).unwrap();
            if let Ok(frame) = scene.render_float() {
                let picture = frame.picture.rgb.iter().flatten();
                assert!(picture.clone().all(|v| v.is_finite()), "{what}");
            }
            false
        }
    }
}

/// Puts odd numbers in a text file, one after the other; gives how many of them are accepted.
fn poke(scene: &Path, file: &Path) -> usize {
    let text = fs::read_to_string(file).unwrap();
    let name = file.file_name().unwrap().to_str().unwrap();
    assert!(!refused(scene, name, "the whole one"));
    let places = numbers(&text);
    assert!(places.len() > 5, "{name}: {places:?}");
    let mut accepted = 0;
    for place in places {
        for odd in ODD {
            let wrong = [&text[..place.start], odd, &text[place.end..]].concat();
            fs::write(file, wrong).unwrap();
            let what = format!("{name}: {odd} at byte {}", place.start);
            accepted += usize::from(!refused(scene, name, &what));
        }
    }
    fs::write(file, text).unwrap();
    accepted
}

#[test]
fn descriptions_and_camera_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let scene = all().remove(0);
    let path = write(
        &scene,
        at,
        &cameras(&[([0.1, 0.2, 0.3], 4.0), ([0.0; 3], 0.0)]),
    );
    assert_eq!(poke(&path, &at.join("needles.json")), 0);
    // In a description TOML's own nan and inf are numbers.
    let text = "[model]\nkind = \"splats\"\npath = \"needles.ply\"\n\
                [camera]\nkind = \"orbit\"\nazimuth = 30\nelevation = 15.0\ndistance = 4\n\
                fov = 45\ntarget = [0, 0.5, 0]\nwidth = 64\nheight = 48\n\
                [render]\nbackground = [0.1, 0.2, 0.3]\ngroup_tiles = [8, 8]\n";
    fs::write(&path, text).unwrap();
    assert_eq!(poke(&path, &path), 0);
}

#[test]
fn paths_and_reconstructions() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let scene = all().remove(0);
    let path = write(&scene, at, "[]");
    let described = |kind: &str, file: &str| {
        let text = format!(
            "[model]\nkind = \"splats\"\npath = \"needles.ply\"\n\
             [camera]\nkind = \"{kind}\"\npath = \"{file}\"\nindex = 0\n"
        );
        fs::write(&path, text).unwrap();
    };
    described("transforms", "t.json");
    let file = at.join("t.json");
    let text = "{\"camera_angle_x\": 0.69, \"frames\": [{\"file_path\": \"a\", \"transform_matrix\": \
                [[1.0, 0.0, 0.0, 0.5], [0.0, 1.0, 0.0, 0.25], [0.0, 0.0, 1.0, 4.0], \
                [0.0, 0.0, 0.0, 1.0]]}]}";
    fs::write(&file, text).unwrap();
    assert_eq!(poke(&path, &file), 0);

    described("colmap", ".");
    fs::write(
        at.join("cameras.txt"),
        "1 PINHOLE 320 200 300.5 310.5 150.25 111.5\n",
    )
    .unwrap();
    let image = "1 0.8 0.6 0.0 0.0 0.5 0.25 4.0 1 a.png\n\n";
    fs::write(at.join("images.txt"), image).unwrap();
    assert_eq!(poke(&path, &at.join("cameras.txt")), 0);
    assert_eq!(poke(&path, &at.join("images.txt")), 0);
}

/// Each 32-bit float of each property, in a plain PLY file.
#[test]
fn floats_of_splat_files() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let scene = all().remove(2);
    write(&scene, at, "[]");
    let path = at.join("near.ply");
    let good = fs::read(&path).unwrap();
    let body = good.len() - 14 * 4 * scene.gaussians.len();
    let mut accepted = vec![];
    for (i, odd) in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY]
        .iter()
        .enumerate()
    {
        for property in 0..14 {
            let mut wrong = good.clone();
            let place = body + 4 * (14 * (i + 3) + property);
            wrong[place..place + 4].copy_from_slice(&odd.to_le_bytes());
            fs::write(&path, wrong).unwrap();
            let what = format!("near.ply: {odd} as property {property}");
            let told = format!("near.ply: vertex {}, property `", i + 3);
            if !refused(&path, &told, &what) {
                accepted.push((property, *odd));
            }
        }
    }
    // Infinite logits stand for opacities of 1 and 0, logarithms of minus infinity for sizes of 0;
    // nothing else may be infinite.
    let (up, down) = (f32::INFINITY, f32::NEG_INFINITY);
    assert_eq!(
        accepted,
        [(10, up), (3, down), (4, down), (5, down), (10, down)]
    );
}

/// Every byte of the chunks' floats in a compressed PLY file.
#[test]
fn floats_of_packed_splat_files() {
    let fixture = Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("golden/tests/fixtures/splats/cloud.compressed.ply");
    let good = fs::read(fixture).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("odd.compressed.ply");
    let end = b"end_header\n";
    let body = good.windows(end.len()).position(|w| w == end).unwrap() + end.len();
    // The first chunk: bounds of centres, scales and colours.
    for property in 0..18 {
        for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut wrong = good.clone();
            let place = body + 4 * property;
            wrong[place..place + 4].copy_from_slice(&odd.to_le_bytes());
            fs::write(&path, &wrong).unwrap();
            let error = files::read(&path, None).unwrap_err().to_string();
            let named = error.contains("odd.compressed.ply") && error.contains("chunk 0");
            assert!(named, "{odd} as property {property}: {error}");
        }
    }
}

/// Every number of a system's description, by itself.
#[test]
fn descriptions_of_systems() {
    fn leaves(table: &toml::Table, path: &str, found: &mut Vec<String>) {
        for (key, value) in table {
            let path = if path.is_empty() {
                key.clone()
            } else {
                format!("{path}.{key}")
            };
            match value {
                toml::Value::Table(inner) => leaves(inner, &path, found),
                toml::Value::Integer(_) | toml::Value::Float(_) => found.push(path),
                _ => {}
            }
        }
    }
    let mut fields = vec![];
    leaves(
        &toml::Table::try_from(System::default()).unwrap(),
        "",
        &mut fields,
    );
    assert!(fields.len() >= 18, "{fields:?}");
    for field in fields {
        for odd in ["nan", "inf", "-inf", "-1.0", "1e400"] {
            let error = System::from_toml(&format!("{field} = {odd}\n"), "s.toml");
            let said = error.expect_err(&format!("{field} = {odd}")).to_string();
            assert!(said.contains("s.toml"), "{said}");
        }
    }
}
