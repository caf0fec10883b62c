//! What a description chooses: model, camera, rules.

use std::fs;

use potamoi_formats::config::Config;
use potamoi_formats::units::VectorOp;

use super::super::*;
use potamoi_reference::splat_unit::{Composited, SplatJob};
use potamoi_reference::{GatherTask, Product, ReferenceUnits, UnitError, Units};

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
    for tiles in ["[0, 0]", "[0, 2]", "[2, 0]"] {
        let render = format!("{model}[render]\ngroup_tiles = {tiles}");
        refused(&render, &format!("render.group_tiles is {tiles}"));
    }
    let side = model.replace("garden", "lantern") + "[render]\ngroup_side = 0";
    refused(&side, "render.group_side is 0");
    let long = format!("{model}[render]\nbackground = [1, 0, 0, 9]");
    refused(&long, "`render.background`: found 4 values, expected 3");
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
        "`camera.kind`: it is missing",
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
    let fixtures = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/fixtures/colmap");
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
        (poses.replace("colmap\"\n", "no\"\n"), "found \"no\""),
        (poses.replace("fixtures/colmap", "no"), "cameras.txt"),
    ] {
        let error = open(&camera).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
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
        let mut twins = ReferenceUnits::new(&config);
        scene.render_fixed(&config, &mut twins).unwrap()
    });
    assert_eq!(shared.picture, split.picture);
    let [a, b] = [shared.counts.streams, split.counts.streams];
    assert!(a.mvoxels_read > b.mvoxels_read && a.rit_written < b.rit_written);
    assert!(a.partial_sums == 0 && b.partial_sums > 0);
    for (model, halo, expected) in [
        (
            "cairn:tensorf",
            "split",
            "write name = \"cairn\" and representation = \"tensorf\"",
        ),
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

/// Counts the bytes of the entries that the gathering unit gets.
struct Entries(ReferenceUnits, usize);

fn bytes(tasks: &[GatherTask]) -> usize {
    tasks
        .iter()
        .map(|task| task.entries.len() * task.vertices.entry_bytes())
        .sum()
}

impl Units for Entries {
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError> {
        self.1 += bytes(tasks);
        self.0.gather(tasks, features)
    }

    fn sums(&mut self, tasks: &[GatherTask], sums: &mut Vec<i32>) -> Result<(), UnitError> {
        self.1 += bytes(tasks);
        self.0.sums(tasks, sums)
    }

    fn vector(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), UnitError> {
        self.0.vector(op, a, b, out)
    }

    fn splats(&mut self, job: &SplatJob<'_>) -> Result<Composited, UnitError> {
        self.0.splats(job)
    }

    fn multiplied(&mut self, product: Product) {
        self.0.multiplied(product);
    }
}

/// Fields in several tables: parts of samples through units with exact sums, or summed
/// beside the unit, and none at all.
#[test]
fn exact_sums_of_every_table_change_no_bit() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let model = "[model]\nkind = \"builtin\"\nname = \"cairn\"\n";
    for representation in ["tensorf", "dvgo"] {
        let halo = "[render]\nhalo = \"split\"\n";
        let text = format!("{model}representation = \"{representation}\"\n{halo}");
        fs::write(&path, text).unwrap();
        let mut scene = Scene::open(path.to_str().unwrap()).unwrap();
        scene.set_size(Some(10), None).unwrap();
        let [rounded, exact] = ["rounded", "exact"].map(|sums| {
            let text = format!(
                "[gu]\nsums = \"{sums}\"\n[vu]\nops = [\"pass\", \"relu\", \"add\", \"multiply\", \"square-sum\", \
                 \"exp\", \"one-minus-exp\", \"sigmoid\", \"softplus\"]\n[vu.exp]\niterations = 18\n\
                 iterations_per_clock = 2\naccumulator_bits = 20\nconstant_bits = 20\n"
            );
            let config = Config::from_toml(&text, "test").unwrap();
            let mut units = Entries(ReferenceUnits::new(&config), 0);
            let frame = scene.render_fixed(&config, &mut units).unwrap();
            (frame, units.1 as u64)
        });
        assert_eq!(rounded.0.picture, exact.0.picture, "{representation}");
        let [of_rounded, of_exact] = [&rounded, &exact].map(|r| r.0.counts.streams);
        assert_eq!(of_rounded.mvoxels_read, of_exact.mvoxels_read);
        // Of all entries that are moved, parts go through the unit with exact sums alone.
        assert_eq!(exact.1, of_exact.rit_written, "{representation}");
        assert!(rounded.1 < of_rounded.rit_written, "{representation}");
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
        let mut twins = ReferenceUnits::new(&config);
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

/// A model of a file has a way about its middle.
#[test]
fn a_model_without_a_way_is_gone_about() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    let text = "[model]\nkind = \"builtin\"\nname = \"lantern\"\n[camera]\nkind = \"orbit\"\n\
                azimuth = 10\nelevation = 5\ndistance = 3\n";
    fs::write(&path, text).unwrap();
    let scene = Scene::open(path.to_str().unwrap()).unwrap();
    assert_eq!(scene.path_length(30.0), None);
    let way = scene.path(1.0, 11).unwrap();
    assert!(
        way[0]
            .world_to_camera
            .abs_diff_eq(scene.camera().world_to_camera, 1e-12)
    );
    // Ten seconds are once around.
    assert!(
        way[10]
            .world_to_camera
            .abs_diff_eq(way[0].world_to_camera, 1e-9)
    );
    let quarter = text.replace("azimuth = 10", "azimuth = 82");
    fs::write(&path, quarter).unwrap();
    let there = Scene::open(path.to_str().unwrap()).unwrap();
    let expected = there.camera().world_to_camera;
    assert!(way[2].world_to_camera.abs_diff_eq(expected, 1e-9));
}
