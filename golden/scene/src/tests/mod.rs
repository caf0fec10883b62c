#![allow(clippy::unwrap_used, clippy::panic)]

mod analytic;
mod described;
mod empty_pairs;
mod fields;
mod masked;
mod precision;
mod recorded_motion;
mod sample_outcomes;
mod shared_cases;
mod splat_bounds;
mod splat_unit;

use std::collections::BTreeMap;
use std::fs;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use potamoi_formats::config::{Config, PRESETS};

use super::*;
use potamoi_reference::ReferenceUnits;

/// A scene that is opened once in this process and shared by copies: building a model of an
/// analytic scene takes up to seconds.
pub(crate) fn opened(name: &str) -> Scene {
    type Kept = BTreeMap<String, Arc<OnceLock<Scene>>>;
    static KEPT: Mutex<Kept> = Mutex::new(Kept::new());
    let mut all = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    let own = Arc::clone(all.entry(name.to_owned()).or_default());
    drop(all);
    own.get_or_init(|| Scene::open(name).unwrap()).clone()
}

#[test]
fn built_in_scenes_hold_their_formats_promise() {
    let config = Config::paper();
    for name in BUILTIN {
        let mut scene = opened(name);
        let own = ["garden", "lantern"].contains(&name);
        scene
            .set_size(Some(if own { 96 } else { 48 }), None)
            .unwrap();
        let float = scene.render_float().unwrap();
        let mut units = ReferenceUnits::new(&config);
        let fixed = scene.render_fixed(&config, &mut units).unwrap();
        let frame = fixed.picture.psnr(&float.picture, |_| true).unwrap();
        let covered = fixed.picture.psnr(&float.picture, |i| float.covered[i]);
        println!("{name}: {frame:.1} dB, covered {:.1} dB", covered.unwrap());
        assert!(
            frame >= 80.0 && covered.unwrap() >= 78.0,
            "{name}: {frame} dB"
        );
        assert_eq!(units.counts().feature_vectors, fixed.counts.feature_vectors);
        assert_eq!(units.counts().gathers, fixed.counts.mvoxels);
        assert_eq!(units.counts().elements, fixed.counts.elements);
        assert_eq!(units.gather_flags(), 0);
        assert_eq!(fixed.flips(&float).is_some(), name == "garden");
    }
}

#[test]
fn what_is_no_scene_is_refused() {
    for (name, expected) in [
        ("mars", "garden, lantern"),
        ("no/such.ply", "no/such.ply"),
        ("no/such.toml", "no/such.toml"),
    ] {
        let error = Scene::open(name).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let manifest = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.lock");
    assert!(Scene::open(manifest).is_err());
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/src/lib.rs");
    let error = Scene::open(source).unwrap_err().to_string();
    assert!(error.contains("`.rs` are not read"), "{error}");
}

#[test]
fn a_configuration_that_cannot_hold_splats_is_refused_by_field() {
    let mut scene = opened("garden");
    scene.set_size(Some(32), Some(32)).unwrap();
    for (text, field) in [
        ("[gu]\nfeature_bits = 12", "gu.feature_bits"),
        ("[gu]\nbanks = 4\nsegments = 3", "gu.segments"),
        (
            "[vu.operands]\nmultiply = [22, 17]\nsquare_sum = 19",
            "vu.operands.multiply",
        ),
        (
            "[vu.operands]\nmultiply = [21, 18]\nsquare_sum = 19",
            "vu.operands.multiply",
        ),
        (
            "[vu.operands]\nmultiply = [22, 18]\nsquare_sum = 18",
            "vu.operands.square_sum",
        ),
        (
            "[vu.exp]\nform = \"piecewise\"\npipelined = true\nbase = \"two\"",
            "vu.exp.base",
        ),
        (
            "[vu]\nops = [\"square-sum\", \"exp\"]\n[vu.exp]\noutput = \"general\"\ninput = \"S3.12\"",
            "vu.exp.output",
        ),
    ] {
        let config = Config::from_toml(text, "test").unwrap();
        let mut units = ReferenceUnits::new(&config);
        let error = scene.render_fixed(&config, &mut units).unwrap_err();
        assert!(error.to_string().contains(field), "{error}");
    }
}

/// What splats send is narrower than 32 bits once forms are held; what fields send is not.
#[test]
fn narrow_operands_change_no_picture_or_are_refused_by_field() {
    let narrow = "[vu.operands]\nmultiply = [22, 18]\nsquare_sum = 19";
    let [paper, narrow] = ["", narrow].map(|text| Config::from_toml(text, "test").unwrap());
    let through = |scene: &Scene, config: &Config| {
        let mut units = ReferenceUnits::new(config);
        scene.render_fixed(config, &mut units)
    };
    let mut garden = opened("garden");
    garden.set_size(Some(64), Some(64)).unwrap();
    let wanted = through(&garden, &paper).unwrap();
    let found = through(&garden, &narrow).unwrap();
    assert!(wanted.picture.rgb == found.picture.rgb);
    assert_eq!(wanted.covered, found.covered);
    assert_eq!(wanted.counts.elements, found.counts.elements);

    // Forms that are not held go beyond their bits, so that holding them is no idle step.
    let cloud = garden.cloud().unwrap();
    let options = garden.splat_options(&paper);
    let mut units = ReferenceUnits::new(&narrow);
    let (camera, profile) = (&garden.camera, garden.profile);
    let error = potamoi_splats::render_fixed(cloud, camera, profile, &options, &mut units);
    let error = error.unwrap_err().to_string();
    assert!(error.contains("vu.operands.square_sum"), "{error}");

    let mut lantern = opened("lantern");
    lantern.set_size(Some(16), Some(16)).unwrap();
    assert!(through(&lantern, &paper).is_ok());
    let error = through(&lantern, &narrow).unwrap_err().to_string();
    let words = ["lantern", "vu.operands.multiply", "flag 3 of stat_errors"];
    assert!(words.iter().all(|w| error.contains(w)), "{error}");
}

/// Errors of fields name the scene and a remedy.
#[test]
fn errors_of_fields_name_their_scene() {
    let config = Config::paper();
    for name in ["cairn:dvgo", "cairn:tensorf", "cairn:ngp"] {
        let scene = opened(name);
        let mut units = ReferenceUnits::new(&config);
        let error = scene.render_fixed(&config, &mut units).unwrap_err();
        let error = error.to_string();
        let words = [name, "`vu.ops`", "use --config fields"];
        assert!(
            words.iter().all(|w| error.contains(w)) && error.starts_with("scene "),
            "{error}"
        );
    }
}

/// A configuration for splats alone refuses fields, and names the presets that render them: all of these,
/// and no others.
#[test]
fn a_refusal_names_the_presets_that_render_the_scene() {
    for (preset, name) in [
        ("lean-splats", "lantern"),
        ("lean-splats", "cairn:ngp"),
        ("lean-fields", "garden"),
        ("parity", "garden"),
    ] {
        let config = Config::preset(preset).unwrap();
        let mut scene = opened(name);
        scene.set_size(Some(4), Some(4)).unwrap();
        let render = |config: &Config| scene.render_fixed(config, &mut ReferenceUnits::new(config));
        let error = render(&config).unwrap_err().to_string();
        let words: Vec<&str> = error.split([' ', ',', '`']).collect();
        assert!(error.contains(": use --config "), "{error}");
        for (preset, _) in PRESETS {
            let renders = render(&Config::preset(preset).unwrap()).is_ok();
            assert_eq!(words.contains(&preset), renders, "{preset}: {error}");
        }
    }
}

#[test]
fn every_splat_format_is_a_scene_and_a_model_of_a_description() {
    let fixtures = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/fixtures/splats");
    let folder = tempfile::tempdir().unwrap();
    let description = folder.path().join("scene.toml");
    for (file, name) in [
        ("cloud.compressed.ply", "a.ply"),
        ("cloud.v3.spz", "a.spz"),
        ("cloud.v4.spz", "b.SPZ"),
        ("cloud.sog", "a.sog"),
    ] {
        let path = folder.path().join(name);
        fs::copy(format!("{fixtures}/{file}"), &path).unwrap();
        let scene = Scene::open(path.to_str().unwrap()).unwrap();
        let Model::Splats(cloud) = scene.model() else {
            panic!("{name} holds splats")
        };
        assert_eq!((cloud.len(), cloud.degree()), (300, 3));
        let text = format!("[model]\nkind = \"splats\"\npath = \"{name}\"\n");
        fs::write(&description, text).unwrap();
        let described = Scene::open(description.to_str().unwrap()).unwrap();
        assert_eq!(described.model(), scene.model());
    }
    let source = concat!(env!("CARGO_MANIFEST_DIR"), "/src/lib.rs");
    for (name, expected) in [
        ("no.obj", "files end in .ply, .splat, .spz, .sog"),
        ("no.spz", "cannot read no.spz"),
        ("nothing", "no built-in scene and no file"),
        (fixtures, "folders but those of SOG"),
        (source, "end in `.rs` are not read: expected .ply, .splat"),
    ] {
        let error = Scene::open(name).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

/// Compact-3DGS is splats whose colours follow the camera: in floating point,
/// in the hardware's formats, in both orders.
#[test]
fn a_compact_3dgs_model_is_a_scene() {
    let fixture = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../tests/fixtures/compact/tiny.npz"
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let open = |azimuth: u32, order: &str| {
        let text = format!(
            "[model]\nkind = \"compact-3dgs\"\npath = \"{fixture}\"\n[camera]\nkind = \"orbit\"\n\
             azimuth = {azimuth}\nwidth = 80\n[render]\norder = \"{order}\"\n"
        );
        fs::write(&path, text).unwrap();
        Scene::open(path.to_str().unwrap()).unwrap()
    };
    let mut bare = Scene::open(fixture).unwrap();
    bare.set_size(Some(80), None).unwrap();
    let shown = bare.render_float().unwrap();
    let covered = shown.covered.iter().filter(|c| **c).count();
    assert!((1000..6400).contains(&covered), "{covered}");
    let same = open(30, "exact").render_float().unwrap();
    assert_eq!(same.picture, shown.picture);
    let config = Config::paper();
    for azimuth in [30, 200] {
        let scene = open(azimuth, "exact");
        let float = scene.render_float().unwrap();
        let mut units = ReferenceUnits::new(&config);
        let fixed = scene.render_fixed(&config, &mut units).unwrap();
        let psnr = fixed.picture.psnr(&float.picture, |_| true).unwrap();
        println!("azimuth {azimuth}: {psnr:.1} dB");
        assert!(psnr >= 78.0, "{psnr} dB");
        assert_eq!(units.counts().feature_vectors, fixed.counts.feature_vectors);
        assert!(fixed.flips(&float).is_some());
        assert!(scene.octree(64).is_some());
    }
    let mut units = ReferenceUnits::new(&config);
    let any = open(30, "approximate");
    let any = any.render_fixed(&config, &mut units).unwrap();
    let psnr = any.picture.psnr(&shown.picture, |_| true).unwrap();
    assert!(psnr >= 20.0, "{psnr} dB");

    // From elsewhere they have other colours, and no others.
    let (here, there) = (open(30, "exact"), open(200, "exact"));
    let Model::Compact(model) = here.model() else {
        panic!("it holds a Compact-3DGS model")
    };
    let clouds = [&here, &there].map(|s| model.seen_from(s.camera().position()));
    assert!((0..clouds[0].len()).any(|i| clouds[0].sh(i) != clouds[1].sh(i)));
    let seen = Scene {
        model: Model::Splats(clouds[0].clone()).into(),
        ..here
    };
    assert_eq!(seen.render_float().unwrap().picture, shown.picture);

    let trace = folder.path().join("trace.npz");
    fs::write(&trace, b"PK").unwrap();
    let error = Scene::open(trace.to_str().unwrap()).unwrap_err();
    assert!(error.to_string().contains("ZIP archive"), "{error}");
    let error = Scene::open("no.npz").unwrap_err().to_string();
    assert!(error.contains("cannot read no.npz"), "{error}");
}

/// A checkpoint is a scene, bare and described, in floating point alone.
#[test]
fn a_tensorf_checkpoint_is_a_scene() {
    let fixture = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/../tests/fixtures/tensorf/tiny.th"
    );
    let mut bare = Scene::open(fixture).unwrap();
    assert_eq!(bare.background(), [1.0; 3]);
    bare.set_size(Some(40), None).unwrap();
    let shown = bare.render_float().unwrap();
    let covered = shown.covered.iter().filter(|c| **c).count();
    assert!((100..1500).contains(&covered), "{covered}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let open = |step: &str| {
        let text = format!(
            "[model]\nkind = \"tensorf\"\npath = \"{fixture}\"\n[camera]\nkind = \"orbit\"\n\
             width = 40\n[render]\nstep = {step}\n"
        );
        fs::write(&path, text).unwrap();
        Scene::open(path.to_str().unwrap()).unwrap()
    };
    // Half an edge is what the checkpoint itself says.
    let same = open("0.5").render_float().unwrap();
    assert_eq!(same.picture, shown.picture);
    let finer = open("0.125").render_float().unwrap();
    let psnr = finer.picture.psnr(&shown.picture, |_| true).unwrap();
    assert!((20.0..60.0).contains(&psnr), "{psnr} dB");
    let config = Config::paper();
    let error = open("1").render_fixed(&config, &mut ReferenceUnits::new(&config));
    let error = error.unwrap_err().to_string();
    assert!(
        error.contains("vu.ops") && error.contains("\"sigmoid\" among the operations"),
        "{error}"
    );
}

/// The model of a description may be anywhere: an error names the description and the field, too.
#[test]
fn errors_of_a_description_s_model_name_the_description() {
    let folder = tempfile::tempdir().unwrap();
    let description = folder.path().join("scene.toml");
    let long = "x".repeat(5000);
    for (model, said) in [
        ("/nowhere/model", "/nowhere/model"),
        ("/nowhere/model.ply", "/nowhere/model.ply"),
        (&long, "5000 bytes: expected a path of at most 4095"),
    ] {
        for kind in ["splats", "ngp", "dvgo", "tensorf", "compact-3dgs"] {
            let text = format!("[model]\nkind = \"{kind}\"\npath = \"{model}\"\n");
            fs::write(&description, text).unwrap();
            let error = Scene::open(description.to_str().unwrap()).unwrap_err();
            let error = error.to_string();
            assert!(error.contains("scene.toml: field `model.path`"), "{error}");
            assert!(error.contains(said), "{kind}: {error}");
        }
    }
}

#[test]
fn a_representation_is_chosen_behind_a_colon_or_in_a_description() {
    let opened = |name: &str| Scene::open(name).map_err(|e| e.to_string());
    let plain = opened("moons").unwrap();
    assert_eq!(plain.model(), opened("moons:voxels").unwrap().model());
    let tree = opened("moons:efficientnerf").unwrap();
    assert_eq!(tree.name(), "moons:efficientnerf");
    assert_eq!(tree.camera(), plain.camera());
    assert!(tree.analytic().is_some());
    let error = opened("moons:cubes").unwrap_err();
    assert!(
        error.contains("representation is cubes: expected voxels, "),
        "{error}"
    );
    let error = opened("garden:voxels").unwrap_err();
    assert!(error.contains("garden has its own"), "{error}");
    assert!(
        opened("meadow:voxels")
            .unwrap_err()
            .contains("built in are")
    );

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let described = |representation: &str| {
        let text = format!(
            "[model]\nkind = \"builtin\"\nname = \"moons\"\nrepresentation = {representation:?}\n"
        );
        fs::write(&path, text).unwrap();
        opened(path.to_str().unwrap())
    };
    let Model::Field(field) = described("efficientnerf").unwrap().model().clone() else {
        panic!("a field")
    };
    assert_eq!(field.algorithm().name, "EfficientNeRF");
    assert!(described("cubes").unwrap_err().contains("representation"));
}
