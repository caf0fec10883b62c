//! Instant-NGP snapshots against an independent writer and renderer,
//! tools/ngp-fixtures.

mod bytes;
mod keys;
mod values;

use std::io::Read as _;
use std::path::{Path, PathBuf};

use glam::DVec3;
use potamoi_fields::algorithms::ngp::Ngp;
use potamoi_fields::{Field as _, render_float};
use potamoi_scene::{Model, Scene};
use serde::Deserialize;

#[derive(Deserialize)]
struct Expected {
    hashed: Vec<bool>,
    points: Vec<Point>,
}

#[derive(Deserialize)]
struct Point {
    at: [f64; 3],
    direction: [f64; 3],
    occupied: bool,
    density: f64,
    colour: [f64; 3],
}

fn fixture(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../tests/fixtures/ngp")
        .join(name)
}

fn expanded() -> Vec<u8> {
    let bytes = std::fs::read(fixture("cube.ingp")).unwrap();
    let mut out = vec![];
    let mut reader = flate2::read::ZlibDecoder::new(&bytes[..]);
    reader.read_to_end(&mut out).unwrap();
    out
}

/// Densities and colours of both snapshots within 1e-5 of the reference, and
/// the same cells occupied.
#[test]
fn densities_and_colours_are_those_of_an_independent_renderer() {
    for name in ["cube", "cascades"] {
        let field = Ngp::load(&fixture(&format!("{name}.ingp"))).unwrap();
        let expected = std::fs::read(fixture(&format!("{name}.json"))).unwrap();
        let expected: Expected = serde_json::from_slice(&expected).unwrap();
        let hashed: Vec<_> = field.tables().iter().map(|t| t.is_hashed()).collect();
        assert_eq!(hashed, expected.hashed, "{name}");
        let streams = (0..field.shape().levels).map(|l| !field.shape().streams(l));
        assert!(streams.eq(hashed));
        let mut places = vec![DVec3::ZERO; field.tables().len()];
        let (mut occupied, mut farthest) = (0, 0f64);
        for point in &expected.points {
            let holds = field.index(point.at.into(), &mut places);
            assert_eq!(holds, point.occupied, "{name} {:?}", point.at);
            occupied += usize::from(holds);
            if !holds {
                continue;
            }
            let mut features = vec![0.0; field.channels()];
            let mut from = 0;
            for (table, place) in field.tables().iter().zip(&places) {
                table.gather(*place, &mut features[from..from + table.channels()]);
                from += table.channels();
            }
            let density = field.density(&features);
            let off = (density - point.density).abs() / point.density.max(1.0);
            let colour = field.colour(&features, point.direction.into(), &mut vec![]);
            let shade = (colour - DVec3::from(point.colour)).abs().max_element();
            farthest = farthest.max(off).max(shade);
        }
        println!("{name}: {occupied} occupied, farthest {farthest:.1e}");
        assert!(farthest < 1e-5, "{name}: {farthest}");
        assert!((5..expected.points.len()).contains(&occupied), "{occupied}");
    }
}

/// The document of `cube.ingp`, changed.
fn patched(change: impl Fn(&mut rmpv::Value)) -> Vec<u8> {
    let mut document = rmpv::decode::read_value(&mut &expanded()[..]).unwrap();
    change(&mut document);
    let mut out = vec![];
    rmpv::encode::write_value(&mut out, &document).unwrap();
    out
}

fn load(bytes: &[u8]) -> Result<Ngp, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.msgpack");
    std::fs::write(&path, bytes).unwrap();
    Ngp::load(&path).map_err(|e| e.to_string())
}

/// The member at a path of keys, the last of which may be new.
fn at<'a>(mut value: &'a mut rmpv::Value, keys: &str) -> &'a mut rmpv::Value {
    for key in keys.split('.') {
        let rmpv::Value::Map(pairs) = value else {
            panic!("{key} of no map")
        };
        let found = pairs.iter().position(|(k, _)| k.as_str() == Some(key));
        let found = found.unwrap_or_else(|| {
            pairs.push((key.into(), rmpv::Value::Map(vec![])));
            pairs.len() - 1
        });
        value = &mut pairs[found].1;
    }
    value
}

#[test]
fn the_plain_document_is_the_same_model() {
    let plain = load(&expanded()).unwrap();
    assert_eq!(plain, Ngp::load(&fixture("cube.ingp")).unwrap());
}

/// A snapshot says by what it is hashed, and a description that says otherwise
/// is refused: it would show something else.
#[test]
fn a_description_cannot_change_the_hash_unit() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).unwrap();
    let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../models");
    let stored = |name: &str| std::fs::read(models.join(name)).unwrap();
    write("vertex.ingp", &stored("cairn.ingp"));
    write("mvoxel.ingp", &stored("cairn-mvoxel.ingp"));
    for file in ["vertex", "mvoxel"] {
        for said in [None, Some("vertex"), Some("mvoxel"), Some("voxel")] {
            let line = said.map_or(String::new(), |unit| format!("hash_unit = \"{unit}\""));
            let text = format!("[model]\nkind = \"ngp\"\npath = \"{file}.ingp\"\n{line}\n");
            write("a.toml", text.as_bytes());
            let opened = Scene::open(folder.path().join("a.toml").to_str().unwrap());
            if said.is_none_or(|unit| unit == file) {
                assert!(opened.is_ok(), "{file}, {said:?}");
                continue;
            }
            let error = opened.unwrap_err().to_string();
            assert!(error.contains("hash_unit"), "{error}");
            if said != Some("voxel") {
                assert!(error.contains("which vertices share an entry"), "{error}");
            }
        }
    }
    // Too few rows for a block.
    let small = patched(|document| {
        *at(document, "encoding.hash_unit") = "mvoxel".into();
        *at(document, "encoding.log2_hashmap_size") = 8.into();
    });
    let error = load(&small).unwrap_err();
    assert!(error.contains("512 rows or more"), "{error}");
}

/// As a scene: opened by its ending and by a description, and rendered.
#[test]
fn snapshots_are_scenes() {
    let path = fixture("cube.ingp");
    let mut scene = Scene::open(path.to_str().unwrap()).unwrap();
    scene.set_size(Some(48), None).unwrap();
    let frame = scene.render_float().unwrap();
    let covered = frame.covered.iter().filter(|c| **c).count();
    assert!((200..48 * 48).contains(&covered), "{covered} pixels");
    let Model::Field(field) = scene.model() else {
        panic!("a field")
    };
    let again = render_float(&**field, scene.camera(), [0.0; 3]).unwrap();
    assert_eq!(again.picture, frame.picture);
    assert!(again.gathered < again.samples, "empty cells are skipped");
    // The unit cube in the world: 3.03 a side around the origin.
    let [low, high] = field.sampling().bounds;
    assert!((low + 0.5 / 0.33).length() < 1e-9 && (high - 0.5 / 0.33).length() < 1e-9);

    let folder = tempfile::tempdir().unwrap();
    let description = folder.path().join("scene.toml");
    let model = format!(
        "[model]\nkind = \"ngp\"\npath = {:?}\n",
        path.to_str().unwrap()
    );
    std::fs::write(&description, &model).unwrap();
    let described = Scene::open(description.to_str().unwrap()).unwrap();
    assert_eq!(described.camera().width, 400);
    std::fs::write(&description, format!("{model}[render]\nstep = 0.5\n")).unwrap();
    let error = Scene::open(description.to_str().unwrap()).unwrap_err();
    assert!(error.to_string().contains("render.step"), "{error}");
}

/// The part that is shown, of a dataset with its own scale and offset: the
/// cube's (x, y, z) are the world's (y, z, x).
#[test]
fn a_crop_is_shown_where_the_dataset_has_it() {
    let field = Ngp::load(&fixture("cascades.ingp")).unwrap();
    let [low, high] = field.sampling().bounds;
    // -1, -1.5, -0.5 to 2, 1.5, and 2.5 where the box ends.
    let expected = |cube: [f64; 3]| {
        let [x, y, z] = cube;
        (DVec3::new(z, x, y) - DVec3::new(0.5, 0.25, 0.625)) / 0.5
    };
    assert!(
        (low - expected([-1.0, -1.5, -0.5])).length() < 1e-12,
        "{low}"
    );
    assert!(
        (high - expected([2.0, 1.5, 2.5])).length() < 1e-12,
        "{high}"
    );
}
