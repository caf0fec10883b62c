#![allow(clippy::unwrap_used)]

use std::path::Path;

use potamoi_containers::torch::Checkpoint;
use proptest::prelude::*;

use super::*;
use crate::Layer;
use crate::test_checkpoints::{Content, harms, survives};
use potamoi_base::file_keys::Fate;

/// A small one, with everything that is read: two features, one frequency.
fn whole() -> Content {
    let state = Content::dict([
        ("density.grid", Content::tensor(&[1, 1, 3, 4, 5])),
        ("k0.grid", Content::tensor(&[1, 2, 3, 4, 5])),
        ("xyz_min", Content::Tensor(vec![3], vec![-1.0; 3])),
        ("xyz_max", Content::Tensor(vec![3], vec![1.0; 3])),
        ("act_shift", Content::Tensor(vec![1], vec![-2.0])),
        ("viewfreq", Content::Tensor(vec![1], vec![1.0])),
        ("rgbnet.0.weight", Content::tensor(&[6, 11])),
        ("rgbnet.0.bias", Content::tensor(&[6])),
        ("rgbnet.2.weight", Content::tensor(&[3, 6])),
        ("rgbnet.2.bias", Content::tensor(&[3])),
        (
            "mask_cache.mask",
            Content::Tensor(vec![2, 2, 2], vec![1.0; 8]),
        ),
        (
            "mask_cache.xyz2ijk_scale",
            Content::Tensor(vec![3], vec![0.5; 3]),
        ),
        (
            "mask_cache.xyz2ijk_shift",
            Content::Tensor(vec![3], vec![0.5; 3]),
        ),
    ]);
    let kwargs = Content::dict([
        ("density_type", Content::text("DenseGrid")),
        ("k0_type", Content::text("DenseGrid")),
        ("num_voxels", Content::Int(60)),
        ("voxel_size_ratio", Content::Tensor(vec![], vec![1.0])),
        ("fast_color_thres", Content::Float(1e-4)),
        ("alpha_init", Content::Float(1e-2)),
    ]);
    Content::dict([
        ("global_step", Content::Int(3)),
        ("model_kwargs", kwargs),
        ("model_state_dict", state),
    ])
}

fn load(path: &Path) -> Result<Dvgo, FieldError> {
    Dvgo::load(path, 0.5)
}

#[derive(serde::Deserialize)]
struct Told {
    sides: [usize; 3],
    points: Vec<[f64; 3]>,
    directions: Vec<[f64; 3]>,
    filled: Vec<bool>,
    alpha: Vec<f64>,
    colour: Vec<[f64; 3]>,
}

/// Written and interpolated by PyTorch, the rest by NumPy (tools/torch-fixtures).
#[test]
fn a_checkpoint_of_pytorch_is_what_pytorch_says() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures/dvgo");
    let told: Told =
        serde_json::from_slice(&std::fs::read(folder.join("tiny.json")).unwrap()).unwrap();
    let field = load(&folder.join("tiny.tar")).unwrap();
    assert_eq!(field.tables[0].points(), told.sides);
    let mut features = vec![0.0; field.tables[0].channels()];
    let mut scratch = vec![];
    for (i, at) in told.points.iter().map(|p| DVec3::from(*p)).enumerate() {
        assert_eq!(field.holds(at), told.filled[i], "{at}");
        let mut place = [DVec3::ZERO];
        field.place(at, &mut place);
        field.tables[0].gather(place[0], &mut features);
        let alpha = -(-field.depth(&features)).exp_m1();
        assert!(
            (alpha - told.alpha[i]).abs() < 1e-6,
            "{alpha} {}",
            told.alpha[i]
        );
        let colour = field.colour(&features, told.directions[i].into(), &mut scratch);
        for (found, expected) in colour.to_array().iter().zip(told.colour[i]) {
            assert!((found - expected).abs() < 1e-6, "{found} {expected}");
        }
    }
    let filled = told.filled.iter().filter(|f| **f).count();
    assert!((10..64).contains(&filled), "{filled}");
}

/// As PyTorch 2.15 writes it with `_use_new_zipfile_serialization=False`.
#[test]
fn a_file_from_before_zip_archives_says_what_to_do() {
    let file = tempfile::NamedTempFile::new().unwrap();
    let head = b"\x80\x02\x8a\nl\xfc\x9cF\xf9 j\xa8P\x19.\x80\x02M\xe9\x03.\x80\x02}q\x00.";
    std::fs::write(file.path(), head).unwrap();
    let error = load(file.path()).unwrap_err().to_string();
    assert!(error.contains("save it again"), "{error}");
}

#[test]
fn the_whole_one_is_read() {
    let field = load(whole().save().path()).unwrap();
    assert_eq!(field.tables[0].points(), [3, 4, 5]);
    assert_eq!((field.interval, field.shift), (0.5, -2.0));
    assert!((field.step - 0.5 * (8f64 / 60.0).cbrt()).abs() < 1e-12);
    assert!(field.mask.is_some());
    let expected = ["global_step", "model_kwargs/alpha_init"];
    assert_eq!(field.notes.not_used(), expected);
}

/// `whole` with one more item, of the whole or of one of its dictionaries.
fn with(key: &str, value: Content) -> Content {
    let Content::Dict(mut root) = whole() else {
        unreachable!()
    };
    match key.split_once('/') {
        None => root.push((key.to_owned(), value)),
        Some((part, name)) => {
            let held = root.iter_mut().find(|(known, _)| known == part);
            let Some((_, Content::Dict(items))) = held else {
                unreachable!()
            };
            items.retain(|(known, _)| known != name);
            items.push((name.to_owned(), value));
        }
    }
    Content::Dict(root)
}

/// Keys of other variants are refused by name, whatever else the file holds or lacks; all others
/// are used or listed.
#[test]
fn every_key_is_honoured_refused_or_listed() {
    let rows = DVGO.keys.iter().map(|row| (row.name, row.fate));
    let new = [("news", Fate::Listed), ("model_kwargs/news", Fate::Listed)];
    for (name, fate) in rows.chain(new) {
        if fate == Fate::Honoured {
            continue;
        }
        let key = name.replace('*', "new");
        let loaded = load(
            with(&key, Content::Tensor(vec![1], vec![0.0]))
                .save()
                .path(),
        );
        match (fate, loaded) {
            (Fate::Refused, Err(error)) => {
                let error = error.to_string();
                assert!(
                    error.contains(&format!("`{key}` cannot be honoured")),
                    "{error}"
                );
                let none = load(with(&key, Content::Int(0)).save().path()).unwrap();
                assert!(!none.notes.not_used().contains(&key), "{key}");
            }
            (Fate::Whole, Err(error)) => {
                let error = error.to_string();
                assert!(
                    error.contains(&format!("`{key}` is out of sequence")),
                    "{error}"
                );
            }
            (Fate::Listed, Ok(field)) => assert!(field.notes.not_used().contains(&key), "{key}"),
            (_, loaded) => unreachable!("{key}: {loaded:?}"),
        }
    }
    // Without what the bounded model needs, the key is still what is named.
    let unbounded = Content::dict([
        ("model_kwargs", Content::dict([])),
        (
            "model_state_dict",
            Content::dict([("scene_center", Content::tensor(&[3]))]),
        ),
    ]);
    let error = load(unbounded.save().path()).unwrap_err().to_string();
    assert!(
        error.contains("`model_state_dict/scene_center`") && error.contains("unbounded"),
        "{error}"
    );
    let kept = load(
        with("model_kwargs/rgbnet_direct", Content::Int(1))
            .save()
            .path(),
    );
    assert!(kept.is_ok());
}

/// `whole` with the layers of a perceptron of four, and with other keys of its `state_dict`
/// in the place of some: from, and to; to nothing removes it.
fn layered(names: [&str; 4], change: Option<(&str, Option<&str>)>) -> Content {
    let Content::Dict(mut root) = whole() else {
        unreachable!()
    };
    for (part, held) in &mut root {
        let Content::Dict(items) = held else { continue };
        if part != "model_state_dict" {
            continue;
        }
        items.retain(|(key, _)| !key.starts_with("rgbnet."));
        for (name, shape) in names.iter().zip([[6, 11], [6, 6], [6, 6], [3, 6]]) {
            items.push((format!("{name}.weight"), Content::tensor(&shape)));
            items.push((format!("{name}.bias"), Content::tensor(&shape[..1])));
        }
        let Some((from, to)) = change else { continue };
        let at = items.iter().position(|(key, _)| key == from).unwrap();
        let (_, value) = items.remove(at);
        items.extend(to.map(|to| (to.to_owned(), value)));
    }
    Content::Dict(root)
}

/// Every layer is used, or the file is refused by the key that is missing or left.
#[test]
fn a_perceptron_is_whole_or_refused_by_key() {
    let nested = ["rgbnet.0", "rgbnet.2.0", "rgbnet.3.0", "rgbnet.4"];
    let plain = ["rgbnet.0", "rgbnet.2", "rgbnet.4", "rgbnet.6"];
    for names in [nested, plain] {
        let field = load(layered(names, None).save().path()).unwrap();
        assert_eq!(field.mlp.layers().len(), 4);
        for name in names {
            for part in ["weight", "bias"] {
                let key = format!("{name}.{part}");
                let made = layered(names, Some((&key, None)));
                let error = load(made.save().path()).unwrap_err().to_string();
                let said = format!("`model_state_dict/{key}` is missing");
                assert!(error.contains(&said), "{key}: {error}");
            }
        }
    }
    // Both parts of a layer are gone, or one is called otherwise.
    let gap = ["rgbnet.0", "rgbnet.2.0", "rgbnet.4.0", "rgbnet.5"];
    let twice = ["rgbnet.0", "rgbnet.2", "rgbnet.2.0", "rgbnet.4"];
    for (names, said) in [
        (gap, "`model_state_dict/rgbnet.3.weight` is missing"),
        (
            twice,
            "`model_state_dict/rgbnet.2.0.weight` is out of sequence",
        ),
    ] {
        let error = load(layered(names, None).save().path())
            .unwrap_err()
            .to_string();
        assert!(error.contains(said), "{error}");
    }
    let more = layered(nested, Some(("rgbnet.4.bias", Some("rgbnet.4.scale"))));
    assert!(load(more.save().path()).is_err());
}

/// Nothing but what Python takes for the wanted value passes: no other type, no other text.
#[test]
fn settings_of_another_type_are_refused_by_key() {
    let key = |name: &str| format!("model_kwargs/{name}");
    for name in ["rgbnet_direct", "density_type", "k0_type"] {
        let mut wrong = vec![
            (Content::None, "None"),
            (Content::Bool(false), "False"),
            (Content::Int(0), "0"),
            (Content::Float(2.0), "2.0"),
            (Content::text("False"), "'False'"),
            (Content::whole(&[1]), "a list"),
        ];
        if name != "rgbnet_direct" {
            wrong.extend([(Content::Int(1), "1"), (Content::Bool(true), "True")]);
        }
        for (value, shown) in wrong {
            let error = load(with(&key(name), value).save().path());
            let error = error.unwrap_err().to_string();
            let said = format!("`{}` is {shown}; expected ", key(name));
            assert!(error.contains(&said), "{error}");
        }
    }
    for value in [Content::Bool(true), Content::Int(1)] {
        assert!(load(with(&key("rgbnet_direct"), value).save().path()).is_ok());
    }
}

/// Codes of a packed grid are no densities; a mask may well be of bytes.
#[test]
fn grids_and_weights_of_integers_are_refused_by_tensor() {
    for (name, shape) in [
        ("density.grid", &[1, 1, 3, 4, 5][..]),
        ("k0.grid", &[1, 2, 3, 4, 5]),
        ("xyz_min", &[3]),
        ("viewfreq", &[1]),
        ("rgbnet.0.weight", &[6, 11]),
        ("rgbnet.2.bias", &[3]),
    ] {
        let bytes = vec![1; shape.iter().product()];
        let key = format!("model_state_dict/{name}");
        let error = load(
            with(&key, Content::Bytes(shape.to_vec(), bytes))
                .save()
                .path(),
        );
        let error = error.unwrap_err().to_string();
        let said = format!("`{key}` is of type uint8; expected floating-point");
        assert!(error.contains(&said), "{error}");
    }
    let mask = Content::Bytes(vec![2; 3], vec![1; 8]);
    let made = with("model_state_dict/mask_cache.mask", mask);
    assert!(load(made.save().path()).is_ok());
}

/// Every key of the files that are read has a row.
#[test]
fn the_table_has_a_row_for_every_key_of_fixtures() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/fixtures");
    let tensorf = &crate::algorithms::tensorf::TENSORF;
    for (file, format) in [("dvgo/tiny.tar", &DVGO), ("tensorf/tiny.th", tensorf)] {
        let keys = Checkpoint::open(&folder.join(file)).unwrap().keys();
        assert!(keys.len() > 20, "{file}");
        for key in keys {
            assert!(format.row(&key).is_some(), "{file}: no row for {key}");
        }
    }
}

#[test]
fn numbers_that_are_none_are_refused_by_tensor() {
    for (key, shape) in [
        ("model_state_dict/density.grid", vec![1, 1, 3, 4, 5]),
        ("model_state_dict/k0.grid", vec![1, 2, 3, 4, 5]),
        ("model_state_dict/rgbnet.2.weight", vec![3, 6]),
    ] {
        for number in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            let mut values = vec![0.5; shape.iter().product()];
            values[7] = number;
            let made = with(key, Content::Tensor(shape.clone(), values));
            let error = load(made.save().path()).unwrap_err().to_string();
            assert!(
                error.contains(&format!("`{key}` is {number} at number 7")),
                "{error}"
            );
        }
    }
}

/// Numbers that would make distances or depths meaningless, each refused by name.
#[test]
fn numbers_out_of_range_are_refused_by_name() {
    for (part, name, value, expected) in [
        ("model_kwargs", "num_voxels", Content::Int(0), "above 0"),
        (
            "model_kwargs",
            "num_voxels",
            Content::Float(f64::NAN),
            "above 0",
        ),
        (
            "model_kwargs",
            "voxel_size_ratio",
            Content::Float(-1.0),
            "above 0",
        ),
        (
            "model_kwargs",
            "fast_color_thres",
            Content::Float(1.0),
            "below 1",
        ),
        (
            "model_kwargs",
            "density_type",
            Content::text("TensoRFGrid"),
            "DenseGrid",
        ),
        (
            "model_state_dict",
            "act_shift",
            Content::Float(f64::INFINITY),
            "a finite number",
        ),
        (
            "model_state_dict",
            "viewfreq",
            Content::Tensor(vec![1], vec![f32::NAN]),
            "finite",
        ),
        (
            "model_state_dict",
            "xyz_max",
            Content::Tensor(vec![3], vec![1.0, f32::INFINITY, 1.0]),
            "finite",
        ),
        // At the minimum.
        (
            "model_state_dict",
            "xyz_max",
            Content::Tensor(vec![3], vec![1.0, -1.0, 1.0]),
            "finite and above xyz_min, [-1, -1, -1]",
        ),
        (
            "model_state_dict",
            "mask_cache.xyz2ijk_scale",
            Content::Tensor(vec![3], vec![f32::NAN; 3]),
            "finite",
        ),
        (
            "model_state_dict",
            "density.grid",
            Content::tensor(&[1, 1, 3, 0, 5]),
            "2 or more vertices",
        ),
        (
            "model_state_dict",
            "density.grid",
            Content::tensor(&[1, 1, 3, 1, 5]),
            "2 or more vertices",
        ),
    ] {
        let Content::Dict(mut root) = whole() else {
            return;
        };
        for (key, held) in &mut root {
            if let (true, Content::Dict(items)) = (key == part, held) {
                let item = items.iter_mut().find(|(key, _)| key == name).unwrap();
                item.1 = value.clone();
            }
        }
        let error = load(Content::Dict(root).save().path())
            .unwrap_err()
            .to_string();
        let field = format!("`{part}/{name}` is ");
        assert!(
            error.contains(&field) && error.contains(expected),
            "{error}"
        );
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn any_contents_are_a_field_or_one_clear_error(harms in harms()) {
        let config = potamoi_formats::config::Config::preset("fields").unwrap();
        survives(&whole(), &harms, load, |field| {
            let _ = field.fixed(&config);
        })?;
    }
}

/// Parts that fit: 1 + 2 channels, one frequency.
fn parts() -> Parts {
    let values = (0..27 * 3).map(|i| i as f32 / 81.0).collect();
    let layer = |inputs: usize, outputs: usize| {
        Layer::new(inputs, vec![0.1; inputs * outputs], vec![0.0; outputs]).unwrap()
    };
    Parts {
        table: Table::new([3; 3], 3, values).unwrap(),
        filled: vec![true; 27],
        bounds: [DVec3::ZERO, DVec3::splat(2.0)],
        shift: -3.0,
        scale: 2.0,
        step: 0.5,
        range: [0.0, f64::INFINITY],
        frequencies: 1,
        mlp: Mlp::new(vec![layer(11, 4), layer(4, 3)]).unwrap(),
    }
}

#[test]
fn parts_that_fit_are_a_model() {
    let field = Dvgo::new(parts()).unwrap();
    // A voxel is one unit wide.
    assert_eq!((field.step, field.interval), (0.5, 1.0));
    assert_eq!(field.frequencies, [1.0]);
    assert!(field.holds(DVec3::ONE) && !field.holds(DVec3::splat(-0.6)));
}

#[test]
fn parts_that_do_not_fit_are_refused_by_name() {
    let refused = |change: &dyn Fn(&mut Parts), part: &str, words: &str| {
        let mut wrong = parts();
        change(&mut wrong);
        let error = Dvgo::new(wrong).unwrap_err().to_string();
        let named = error.contains(&format!("`{part}` is "));
        assert!(named && error.contains(words), "{part}, {words}: {error}");
    };
    let flat = |points: [usize; 3]| {
        let count = points.iter().product::<usize>();
        Table::new(points, 3, vec![0.0; 3 * count]).unwrap()
    };
    refused(&|p| p.frequencies = 2, "mlp", "17 inputs, 3 outputs");
    refused(&|p| p.frequencies = 0, "mlp", "5 inputs, 3 outputs");
    refused(&|p| p.frequencies = 17, "mlp", "11 inputs");
    refused(
        &|p| p.mlp = Mlp::new(vec![Layer::new(11, vec![0.0; 22], vec![0.0; 2]).unwrap()]).unwrap(),
        "mlp",
        "2 outputs",
    );
    for axis in 0..3 {
        let mut points = [3; 3];
        points[axis] = 1;
        refused(
            &|p| p.table = flat(points),
            "table",
            "2 or more along each axis",
        );
    }
    refused(
        &|p| p.filled.truncate(26),
        "filled",
        "26 vertices; expected 27",
    );
    refused(
        &|p| p.filled.push(true),
        "filled",
        "28 vertices; expected 27",
    );
    for (change, words) in [
        (
            &(|p: &mut Parts| p.bounds[1].y = 0.0) as &dyn Fn(&mut Parts),
            "a box",
        ),
        (&|p| p.bounds[1].x = f64::INFINITY, "a box"),
        (&|p| p.bounds[0].z = f64::NAN, "a box"),
        (&|p| p.bounds.swap(0, 1), "a box"),
        (&|p| p.shift = f64::NAN, "a shift"),
        (&|p| p.scale = 0.0, "a scale"),
        (&|p| p.scale = f64::INFINITY, "a scale"),
        (&|p| p.step = 0.0, "a step"),
        (&|p| p.step = -0.5, "a step"),
        (&|p| p.step = f64::NAN, "a step"),
        (&|p| p.range[0] = -1.0, "a range"),
        (&|p| p.range = [2.0, 1.0], "a range"),
        (&|p| p.range[1] = f64::NAN, "a range"),
    ] {
        refused(change, "numbers", words);
    }
}
