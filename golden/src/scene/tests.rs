#![allow(clippy::unwrap_used, clippy::panic)]

use std::fs;

use potamoi_formats::config::Config;

use super::*;
use crate::units::Twins;

#[test]
fn built_in_scenes_hold_their_formats_promise() {
    let config = Config::paper();
    for name in BUILTIN {
        let mut scene = Scene::open(name).unwrap();
        let own = ["garden", "lantern"].contains(&name);
        scene
            .set_size(Some(if own { 160 } else { 80 }), None)
            .unwrap();
        let float = scene.render_float().unwrap();
        let mut units = Twins::new(&config);
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
fn descriptions_name_model_camera_and_rules() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let open = |text: &str| {
        fs::write(&path, text).unwrap();
        Scene::open(path.to_str().unwrap())
    };
    let scene = open(
        "[model]\nkind = \"builtin\"\nname = \"garden\"\n[camera]\nkind = \"orbit\"\n\
         azimuth = 10\ndistance = 5\nwidth = 60\nheight = 40\n\
         [render]\nprofile = \"gsplat\"\nbackground = [0, 0.5, 1]\ngroup_tiles = [2, 2]",
    )
    .unwrap();
    assert_eq!((scene.camera().width, scene.camera().height), (60, 40));
    assert_eq!(scene.profile(), Profile::Gsplat);
    assert_eq!(scene.background(), [0.0, 0.5, 1.0]);
    fs::write(
        folder.path().join("camera.json"),
        r#"{"width": 40, "height": 20, "fx": 30.5, "fy": 31, "position": [1, 2, 3],
            "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}"#,
    )
    .unwrap();
    let scene = open(
        "[model]\nkind = \"builtin\"\nname = \"lantern\"\n[camera]\nkind = \"opencv-json\"\n\
         path = \"camera.json\"\nwidth = 80\n[render]\nstep = 0.25\ngroup_side = 7",
    )
    .unwrap();
    assert_eq!((scene.camera().width, scene.camera().height), (80, 40));
    assert_eq!(scene.camera().focal.x, 61.0);

    let refused = |text: &str, expected: &str| {
        let error = open(text).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    };
    let model = "[model]\nkind = \"builtin\"\nname = \"garden\"\n";
    refused("", "model");
    refused("[model]\nkind = \"nerf\"", "nerf");
    refused("[model]\nkind = \"builtin\"\nname = \"mars\"", "mars");
    refused("[model]\nkind = \"splats\"\npath = \"no.ply\"", "no.ply");
    refused(&format!("{model}colour = 3"), "colour");
    refused(&format!("{model}[render]\nprofile = \"x\""), "inria");
    refused(&format!("{model}[render]\nstep = 1"), "render.step");
    refused(
        &format!("{model}[camera]\nkind = \"orbit\"\nfov = 0"),
        "camera.fov",
    );
    refused(
        &format!("{model}[camera]\nkind = \"orbit\"\nelevation = 90"),
        "elevation",
    );
    refused(
        &format!("{model}[camera]\nkind = \"orbit\"\ndistance = nan"),
        "distance",
    );
    refused(
        &format!("{model}[camera]\nkind = \"orbit\"\nwidth = 0"),
        "width is 0",
    );
    for distance in ["0", "1e10"] {
        let camera = format!("{model}[camera]\nkind = \"orbit\"\ndistance = {distance}");
        refused(&camera, "camera.distance");
    }
    let target = "[camera]\nkind = \"orbit\"\ntarget = [0, inf, 0]";
    refused(&format!("{model}{target}"), "camera.target");
    for background in ["[0, -0.1, 0]", "[nan, 0, 0]", "[16, 0, 0]"] {
        let render = format!("{model}[render]\nbackground = {background}");
        refused(&render, "render.background");
    }
    refused(&format!("{model}[render]\norder = \"any\""), "render.order");
    // Values of the wrong kind are named too.
    let orbit = format!("{model}[camera]\nkind = \"orbit\"\n");
    refused(&format!("{orbit}width = \"x\""), "`camera.width`");
    refused(
        &format!("{orbit}target = [0, \"y\", 0]"),
        "`camera.target[1]`",
    );
    refused(&format!("{orbit}widht = 3"), "widht");
    refused(
        &format!("{model}[camera]\nkind = \"tripod\""),
        "`camera.kind`",
    );
    refused(&format!("{model}[camera]\nkind = 3"), "`camera.kind`");
    refused(
        &format!("{model}[camera]\nfov = 3"),
        "`camera.kind` is missing",
    );
    refused(&format!("{model}[render]\nstep = true"), "`render.step`");
    let lantern = model.replace("garden", "lantern");
    refused(
        &format!("{lantern}[render]\nbackground = [8, 0, 0]"),
        "render.background",
    );
    let file = "[camera]\nkind = \"opencv-json\"\npath = \"camera.json\"\nindex = 4";
    refused(&format!("{model}{file}"), "camera.index is 4");
}

/// A camera of a file is the first of a path, of the size that is asked for.
#[test]
fn the_cameras_of_a_file_are_a_path() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let one = r#"{"width": 40, "height": 20, "fx": 30, "fy": 31, "position": [1, 2, 3],
        "rotation": [[1, 0, 0], [0, 1, 0], [0, 0, 1]]}"#;
    let far = one.replace("[1, 2, 3]", "[5, 2, 3]");
    fs::write(
        folder.path().join("camera.json"),
        format!("[{one}, {one}, {far}]"),
    )
    .unwrap();
    let fixtures = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/colmap");
    let open = |camera: &str| {
        let model = "[model]\nkind = \"builtin\"\nname = \"garden\"\n";
        fs::write(&path, format!("{model}[camera]\n{camera}")).unwrap();
        Scene::open(path.to_str().unwrap())
    };
    let poses = format!("kind = \"colmap\"\npath = \"{fixtures}\"\n");
    let scene = open(&format!("{poses}name = \"shots/view 6.png\"\nwidth = 32")).unwrap();
    assert_eq!((scene.camera().width, scene.camera().height), (32, 24));
    assert_eq!(scene.camera().focal.x, 25.0);
    let frames = scene.path(30.0, 3).unwrap();
    assert_eq!(frames[0], *scene.camera());
    // Each keeps its shape.
    let sizes: Vec<_> = frames.iter().map(|c| (c.width, c.height)).collect();
    assert_eq!(sizes, [(32, 24), (32, 20), (32, 24)]);
    let mut again = open(&format!("{poses}index = 2")).unwrap();
    again.set_size(Some(32), None).unwrap();
    assert_eq!(again.camera(), scene.camera());
    let error = again.path(30.0, 4).unwrap_err().to_string();
    assert!(error.contains("frames is 4: expected at most 3"), "{error}");
    let scene = open("kind = \"opencv-json\"\npath = \"camera.json\"\nindex = 1").unwrap();
    let frames = scene.path(1.0, 2).unwrap();
    assert_eq!(frames[1].position().x, 5.0);
    for (camera, expected) in [
        (format!("{poses}name = \"no.png\""), "camera.name is no.png"),
        (format!("{poses}index = 5"), "camera.index is 5"),
        (format!("{poses}index = 0\nname = \"a\""), "left out"),
        (poses.replace("colmap\"\n", "no\"\n"), "`no`"),
        (poses.replace("fixtures/colmap", "no"), "cameras.txt"),
    ] {
        let error = open(&camera).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
    let error = Scene::open("garden").unwrap().path(30.0, 1).unwrap_err();
    assert!(error.to_string().contains("one of a file"), "{error}");
}

/// A halo chosen in a description changes what is moved and not what is seen.
#[test]
fn a_halo_changes_no_bit_of_a_described_scene() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let config = Config::paper();
    let open = |model: &str, halo: &str| {
        let text = format!(
            "[model]\nkind = \"builtin\"\nname = \"{model}\"\n[render]\nhalo = \"{halo}\"\n"
        );
        fs::write(&path, text).unwrap();
        Scene::open(path.to_str().unwrap())
    };
    let [shared, split] = ["shared", "split"].map(|halo| {
        let mut scene = open("lantern", halo).unwrap();
        scene.set_size(Some(48), None).unwrap();
        let mut twins = Twins::new(&config);
        scene.render_fixed(&config, &mut twins).unwrap()
    });
    assert_eq!(shared.picture, split.picture);
    let [a, b] = [shared.counts.streams, split.counts.streams];
    assert!(a.mvoxels_read > b.mvoxels_read && a.rit_written < b.rit_written);
    assert!(a.partial_sums == 0 && b.partial_sums > 0);
    for (model, halo, expected) in [
        (
            "lantern",
            "open",
            "render.halo is open: expected shared or split",
        ),
        ("garden", "split", "render.halo is given"),
    ] {
        let error = open(model, halo).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

/// Both orders, by way of a description, and what each says of itself.
#[test]
fn approximate_order_counts_its_inversions() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let config = Config::paper();
    let [exact, approximate] = ["exact", "approximate"].map(|order| {
        let text = format!(
            "[model]\nkind = \"builtin\"\nname = \"garden\"\n[render]\norder = \"{order}\"\n"
        );
        fs::write(&path, text).unwrap();
        let mut scene = Scene::open(path.to_str().unwrap()).unwrap();
        scene.set_size(Some(100), None).unwrap();
        let mut twins = Twins::new(&config);
        scene.render_fixed(&config, &mut twins).unwrap()
    });
    let counts = exact.counts.splats.unwrap();
    assert_eq!(counts.inversions, 0);
    assert!(counts.records_held > 100 && counts.entries_held > counts.records_held);
    let counts = approximate.counts.splats.unwrap();
    assert!(
        counts.inversions > 100 && counts.records_held == 0,
        "{counts:?}"
    );
    let psnr = approximate.picture.psnr(&exact.picture, |_| true).unwrap();
    assert!((20.0..80.0).contains(&psnr), "{psnr} dB");
}

/// A built-in scene keeps its vertical axis under a description's camera.
#[test]
fn an_orbit_around_a_built_in_scene_is_upright() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    for (name, up) in [("garden", DVec3::Y), ("lantern", DVec3::Z)] {
        let text =
            format!("[model]\nkind = \"builtin\"\nname = \"{name}\"\n[camera]\nkind = \"orbit\"\n");
        fs::write(&path, text).unwrap();
        let scene = Scene::open(path.to_str().unwrap()).unwrap();
        let tip = scene.camera().world_to_camera.transform_vector3(up);
        assert!(tip.y < -0.9, "{name}: {tip}");
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
    let mut scene = Scene::open("garden").unwrap();
    scene.set_size(Some(32), Some(32)).unwrap();
    for (text, field) in [
        ("[gu]\nfeature_bits = 12", "gu.feature_bits"),
        ("[gu]\nbanks = 4\nsegments = 3", "gu.segments"),
    ] {
        let config = Config::from_toml(text, "test").unwrap();
        let mut units = Twins::new(&config);
        let error = scene.render_fixed(&config, &mut units).unwrap_err();
        assert!(error.to_string().contains(field), "{error}");
    }
}

#[test]
fn every_splat_format_is_a_scene_and_a_model_of_a_description() {
    let fixtures = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/fixtures/splats");
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
        (fixtures, "no built-in scene and no file"),
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
        "/tests/fixtures/compact/tiny.npz"
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
        let mut units = Twins::new(&config);
        let fixed = scene.render_fixed(&config, &mut units).unwrap();
        let psnr = fixed.picture.psnr(&float.picture, |_| true).unwrap();
        println!("azimuth {azimuth}: {psnr:.1} dB");
        assert!(psnr >= 78.0, "{psnr} dB");
        assert_eq!(units.counts().feature_vectors, fixed.counts.feature_vectors);
        assert!(fixed.flips(&float).is_some());
        assert!(scene.octree(64).is_some());
    }
    let mut units = Twins::new(&config);
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
        model: Model::Splats(clouds[0].clone()),
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
        "/tests/fixtures/tensorf/tiny.th"
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
    let error = open("1").render_fixed(&config, &mut Twins::new(&config));
    let error = error.unwrap_err().to_string();
    assert!(
        error.contains("vu.ops") && error.contains("\"sigmoid\" among the operations"),
        "{error}"
    );
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
    assert_eq!(field.kind(), "EfficientNeRF");
    assert!(described("cubes").unwrap_err().contains("representation"));
}
