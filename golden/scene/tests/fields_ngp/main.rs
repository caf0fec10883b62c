//! Instant-NGP snapshots against an independent writer and renderer,
//! tools/ngp-fixtures.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use std::io::Read as _;
use std::path::{Path, PathBuf};

use glam::DVec3;
use potamoi_fields::ngp::Ngp;
use potamoi_fields::{Field as _, render_float};
use potamoi_scene::{Model, Scene};
use proptest::prelude::*;

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

/// Each field that does not fit is refused by its name.
/// Sections of a snapshot that are read; of others the name alone is known.
const SECTIONS: [&str; 7] = [
    "encoding",
    "network",
    "dir_encoding",
    "rgb_network",
    "snapshot",
    "snapshot.nerf",
    "snapshot.nerf.dataset",
];

/// The format by its name in the book.
fn format() -> &'static potamoi_base::record::Format {
    let all = potamoi_scene::file_formats::formats();
    all.iter()
        .find(|format| format.name == "Instant-NGP")
        .unwrap()
}

#[test]
fn every_key_of_fixtures_has_a_row() {
    fn walk(value: &rmpv::Value, path: &str, found: &mut Vec<String>) {
        for (key, value) in value.as_map().unwrap() {
            let key = key.as_str().unwrap();
            let path = match path {
                "" => key.to_owned(),
                path => format!("{path}.{key}"),
            };
            match SECTIONS.contains(&&*path) {
                true => walk(value, &path, found),
                false => found.push(path),
            }
        }
    }
    let mut found = vec![];
    let document = rmpv::decode::read_value(&mut &expanded()[..]).unwrap();
    walk(&document, "", &mut found);
    assert!(found.len() > 25, "{found:?}");
    for key in found {
        assert!(format().row(&key).is_some(), "no row for {key}");
    }
}

/// A key more in every section: listed, or refused where its row says so.
#[test]
fn keys_that_are_not_used_are_listed_or_refused() {
    use potamoi_base::record::Fate;
    use rmpv::Value;
    let with = |key: &str| {
        let bytes = patched(|d| *at(d, key) = Value::Map(vec![("x".into(), 1.into())]));
        load(&bytes).map(|field| field.notes().not_used().join(", "))
    };
    for section in SECTIONS {
        let key = format!("{section}.news");
        let listed = with(&key).unwrap();
        assert!(listed.contains(&key), "{key}: {listed}");
    }
    assert!(with("news").unwrap().contains("news"));
    for row in format().keys {
        let key = row.name.replace('*', "x");
        match row.fate {
            Fate::Honoured => {}
            Fate::Listed if key.starts_with("dir_encoding.nested.") => {}
            Fate::Listed => assert!(with(&key).unwrap().contains(&key), "{key}"),
            Fate::Refused => {
                let error = with(&key).unwrap_err();
                assert!(
                    error.contains(&format!("`{key}` cannot be honoured")),
                    "{error}"
                );
            }
        }
    }
}

#[test]
fn numbers_that_are_none_and_boxes_that_are_none_are_refused() {
    use rmpv::Value;
    // Halves: not a number, and plus and minus infinity.
    for half in [0x7e00u16, 0x7c00, 0xfc00] {
        // Parameters of this fixture have 32 bits, of which these would be half.
        {
            let field = "snapshot.density_grid_binary";
            let bytes = patched(|d| {
                let Value::Binary(all) = at(d, field) else {
                    unreachable!()
                };
                all[20..22].copy_from_slice(&half.to_le_bytes());
            });
            let error = load(&bytes).unwrap_err();
            let expected = format!("`{field}` is {} at number 10", half::f16::from_bits(half));
            assert!(error.contains(&expected), "{error}");
        }
    }
    let corner = |x: f64, yz: f64| Value::Array(vec![x.into(), yz.into(), yz.into()]);
    let aabb = |min: f64, max: f64| {
        Value::Map(vec![
            ("min".into(), corner(min, 0.2)),
            ("max".into(), corner(max, 0.8)),
        ])
    };
    for (min, max) in [(0.4, f64::NAN), (f64::NAN, 0.6), (0.6, 0.4), (0.5, 0.5)] {
        let error = load(&patched(|d| {
            *at(d, "snapshot.render_aabb") = aabb(min, max)
        }));
        let error = error.unwrap_err();
        let said = "finite corners, `min` below `max`";
        assert!(
            error.contains("snapshot.render_aabb` is [") && error.contains(said),
            "{error}"
        );
    }
    let off = load(&patched(|d| {
        *at(d, "snapshot.render_aabb") = aabb(5.0, 6.0)
    }));
    let off = off.unwrap_err();
    assert!(off.contains("a box that meets `aabb`"), "{off}");
    // One number too many.
    let long = Value::Array(vec![0.5.into(); 4]);
    let error = load(&patched(|d| {
        *at(d, "snapshot.nerf.dataset.offset") = long.clone()
    }));
    let error = error.unwrap_err();
    assert!(
        error.contains("offset") && error.contains("too many values"),
        "{error}"
    );
    for word in ["u32", "struct", "invalid type", "marker"] {
        for (field, value) in [
            ("encoding", Value::from(3)),
            ("snapshot.version", Value::from("one")),
            ("snapshot.params_binary", Value::Array(vec![])),
            ("encoding.n_levels", Value::from(-1)),
            ("encoding.n_levels", Value::from(1.5)),
        ] {
            let error = load(&patched(|d| *at(d, field) = value.clone())).unwrap_err();
            assert!(
                error.contains(field) && !error.contains(word),
                "{word}: {error}"
            );
        }
    }
}

/// A number without a fraction is whole, however it is written.
#[test]
fn whole_numbers_may_have_a_point() {
    use rmpv::Value;
    let fields = [
        "encoding.n_levels",
        "snapshot.version",
        "snapshot.nerf.aabb_scale",
    ];
    let bytes = patched(|d| {
        for field in fields {
            let whole = at(d, field).as_u64().unwrap() as f64;
            *at(d, field) = Value::F64(whole);
        }
        *at(d, "snapshot.linear_colors") = false.into();
        *at(d, "snapshot.nerf.linear_colors") = false.into();
    });
    assert_eq!(load(&bytes).unwrap(), load(&expanded()).unwrap());
}

#[test]
fn what_contradicts_itself_is_refused_by_name() {
    use rmpv::Value;
    let per_level = |d: &mut Value| at(d, "encoding.n_features_per_level").as_u64().unwrap();
    let levels = |d: &mut Value| at(d, "encoding.n_levels").as_u64().unwrap();
    let all = |more_levels: u64, more: u64| {
        load(&patched(|d| {
            let all = per_level(d) * (levels(d) + more_levels) + more;
            *at(d, "encoding.n_features") = all.into();
        }))
    };
    assert!(all(0, 0).is_ok());
    assert!(all(0, 1).unwrap_err().contains("`encoding.n_features` is"));
    assert!(all(1, 0).unwrap_err().contains("`encoding.n_levels` is"));
    let harmonics = || {
        let name = ("otype".into(), "SphericalHarmonics".into());
        let inputs = ("n_dims_to_encode".into(), 3.into());
        Value::Array(vec![Value::Map(vec![name, inputs])])
    };
    for (field, values) in [
        (
            "encoding.per_level_scale",
            vec![("encoding.per_level_scale", f64::NAN.into())],
        ),
        (
            "encoding.per_level_scale",
            vec![("encoding.per_level_scale", (-3.0).into())],
        ),
        (
            "encoding.type",
            vec![
                ("encoding.otype", "HashGrid".into()),
                ("encoding.type", "Dense".into()),
            ],
        ),
        (
            "snapshot.linear_colors",
            vec![("snapshot.linear_colors", true.into())],
        ),
        (
            "dir_encoding.nested",
            vec![
                ("dir_encoding.otype", "SphericalHarmonics".into()),
                ("dir_encoding.nested", harmonics()),
            ],
        ),
        (
            "dir_encoding.degree",
            vec![
                ("dir_encoding.otype", "Composite".into()),
                ("dir_encoding.nested", harmonics()),
                ("dir_encoding.degree", 3.into()),
            ],
        ),
    ] {
        let bytes = patched(|d| {
            for (field, value) in &values {
                *at(d, field) = value.clone();
            }
        });
        let error = load(&bytes).unwrap_err();
        assert!(error.contains(&format!("`{field}` is")), "{error}");
    }
}

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

#[test]
fn what_does_not_fit_is_refused_by_name() {
    use rmpv::Value;
    let short = |size: usize| Value::Binary(vec![0; size]);
    let cases: Vec<(&str, Value)> = vec![
        ("snapshot.version", 2.into()),
        ("snapshot.mode", "sdf".into()),
        ("snapshot.params_binary", short(7)),
        ("snapshot.params_type", "__bfloat".into()),
        ("snapshot.n_params", 3.into()),
        ("snapshot.density_grid_size", 64.into()),
        ("snapshot.density_grid_binary", short(128 * 128)),
        ("snapshot.nerf.aabb_scale", 3.into()),
        ("snapshot.nerf.aabb_scale", 256.into()),
        ("snapshot.nerf.dataset.from_mitsuba", true.into()),
        ("snapshot.nerf.dataset.is_hdr", true.into()),
        ("snapshot.nerf.dataset.scale", 0.into()),
        ("snapshot.nerf.dataset.n_extra_learnable_dims", 8.into()),
        ("encoding.otype", "DenseGrid".into()),
        ("encoding.interpolation", "Smoothstep".into()),
        ("encoding.n_levels", 0.into()),
        ("encoding.n_features_per_level", 3.into()),
        ("encoding.log2_hashmap_size", 60.into()),
        ("encoding.base_resolution", 1_000_000.into()),
        ("encoding.hash_unit", "voxel".into()),
        ("encoding.per_level_scale", 0.5.into()),
        ("encoding.per_level_scale", 64.0.into()),
        ("dir_encoding.otype", "Frequency".into()),
        ("network.otype", "CutlassMLP".into()),
        ("network.activation", "Sine".into()),
        ("network.n_neurons", 48.into()),
        ("rgb_network.n_hidden_layers", 0.into()),
        ("rgb_network.output_activation", "Sigmoid".into()),
    ];
    for (field, value) in cases {
        let bytes = patched(|document| *at(document, field) = value.clone());
        let error = load(&bytes).unwrap_err();
        assert!(error.contains(&format!("`{field}` is ")), "{error}");
    }
    // Sizes that disagree with the number of parameters.
    for (field, value) in [("encoding.n_levels", 5), ("network.n_neurons", 64)] {
        let bytes = patched(|document| *at(document, field) = value.into());
        let error = load(&bytes).unwrap_err();
        assert!(error.contains("snapshot.params_binary"), "{error}");
    }
    let error = load(&patched(|d| *at(d, "snapshot.nerf.aabb_scale") = 2.into())).unwrap_err();
    assert!(error.contains("snapshot.aabb"), "{error}");
    // Of another kind, missing, or not a snapshot at all.
    let error = load(&patched(|d| *at(d, "encoding.n_levels") = "x".into())).unwrap_err();
    assert!(error.contains("field `encoding.n_levels`"), "{error}");
    let error = load(&patched(|d| *at(d, "snapshot") = Value::Map(vec![]))).unwrap_err();
    assert!(error.contains("`version` is missing"), "{error}");
    for bytes in [&b""[..], b"\x80", b"\x78\x9c\x00", b"\x1f\x8b", b"ply\n"] {
        assert!(load(bytes).is_err());
    }
    let error = Ngp::load(Path::new("no.ingp")).unwrap_err().to_string();
    assert!(error.contains("cannot read snapshot no.ingp"), "{error}");
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
