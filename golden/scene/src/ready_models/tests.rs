#![allow(clippy::unwrap_used)]

use std::path::Path;

use potamoi_formats::config::Config;

use crate::{Model, Representation, Scene};
use potamoi_analytic::Analytic;
use potamoi_reference::ReferenceUnits;

/// Decibels, in the order of [`Representation::ALL`].
const FLOORS: [f64; 7] = [41.2, 40.5, 40.2, 43.3, 19.5, 30.4, 20.1];
const MVOXEL_FLOOR: f64 = 44.3;
/// Stored models, bytes in all.
const MOST_BYTES: u64 = 20 << 20;

fn scene(name: &str) -> Scene {
    let mut scene = crate::tests::opened(name);
    scene.set_size(Some(100), Some(100)).unwrap();
    scene
}

/// Floors are what was measured at this size, less 1 dB. Pixels are so large here
/// that the filter of splats, a third of a pixel, widens them by half a voxel.
#[test]
fn every_representation_of_a_scene_shows_it() {
    let truth = scene("cairn").render_truth().unwrap().picture;
    for (kind, floor) in Representation::ALL.into_iter().zip(FLOORS) {
        let scene = scene(&format!("cairn:{}", kind.name()));
        assert_eq!(scene.analytic(), Some(Analytic::Cairn));
        assert_eq!(scene.name(), format!("cairn:{}", kind.name()));
        let found = scene.render_float().unwrap().picture;
        let psnr = found.psnr(&truth, |_| true).unwrap();
        println!("{}: {psnr:.1} dB", kind.name());
        assert!(psnr > floor, "{}: {psnr} dB, floor {floor}", kind.name());
    }
}

/// The floor is what was measured at this size, less 1 dB.
#[test]
fn the_hash_grid_of_mvoxels_shows_its_scene() {
    let scene = scene("cairn:ngp-mvoxel");
    let truth = scene.render_truth().unwrap().picture;
    let found = scene.render_float().unwrap().picture;
    let psnr = found.psnr(&truth, |_| true).unwrap();
    println!("{psnr:.1} dB");
    assert!(psnr > MVOXEL_FLOOR, "{psnr} dB");
    let error = Scene::open("moons:ngp-mvoxel").unwrap_err().to_string();
    assert!(error.contains("voxels, dvgo"), "{error}");
}

/// Mirrors, which three layers do not hold, have a floor of their own.
#[test]
fn fitted_files_load_and_show_their_scene() {
    for analytic in Analytic::ALL {
        let mut scene = crate::tests::opened(&format!("{}:ngp", analytic.name()));
        scene.set_size(Some(32), Some(32)).unwrap();
        let truth = scene.render_truth().unwrap().picture;
        let found = scene.render_float().unwrap().picture;
        let psnr = found.psnr(&truth, |_| true).unwrap();
        println!("{}: {psnr:.1} dB", analytic.name());
        let floor = match analytic {
            Analytic::Chrome => 20.5,
            _ => 30.0,
        };
        assert!(psnr > floor, "{}: {psnr} dB", analytic.name());
    }
}

/// 28 dB of diffuse scenes, at the size that splats are made for; the others
/// have floors of their own.
#[test]
fn splats_show_a_diffuse_scene_to_28_db() {
    splats_show(&[Analytic::Cairn], &[Representation::Splats]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn splats_show_every_scene_to_its_floor() {
    let kinds = [Representation::Splats, Representation::Compact];
    splats_show(&Analytic::ALL, &kinds);
}

fn splats_show(scenes: &[Analytic], kinds: &[Representation]) {
    for &analytic in scenes {
        let floor = match analytic {
            Analytic::Vase => 29.0,
            Analytic::Chrome => 18.5,
            _ => 28.0,
        };
        show(analytic, kinds, 400, floor);
    }
}

/// The same of sampled grids: the scene that they show least well of
/// the diffuse ones.
#[test]
fn grids_show_thin_parts_to_28_db() {
    show(Analytic::Lattice, &GRIDS[..2], 200, 28.0);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn grids_and_factors_show_diffuse_scenes_to_28_db() {
    for analytic in Analytic::ALL {
        let floor = if analytic == Analytic::Chrome {
            18.5
        } else {
            28.0
        };
        show(analytic, &GRIDS, 400, floor);
    }
}

const GRIDS: [Representation; 3] = [
    Representation::Voxels,
    Representation::Dvgo,
    Representation::Tensorf,
];

fn show(analytic: Analytic, kinds: &[Representation], side: u32, floor: f64) {
    let mut truth = None;
    for kind in kinds {
        let name = format!("{}:{}", analytic.name(), kind.name());
        let mut scene = crate::tests::opened(&name);
        scene.set_size(Some(side), Some(side)).unwrap();
        let truth = truth.get_or_insert_with(|| scene.render_truth().unwrap().picture);
        let found = scene.render_float().unwrap().picture;
        let psnr = found.psnr(truth, |_| true).unwrap();
        println!("{name}: {psnr:.1} dB");
        assert!(psnr >= floor, "{name}: {psnr} dB, floor {floor}");
    }
}

#[test]
fn stored_models_are_small() {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../models");
    let files = std::fs::read_dir(folder).unwrap();
    let files = files.map(|file| file.unwrap().path());
    let models = files.filter(|file| file.extension().is_none_or(|kind| kind != "md"));
    let sizes = models.map(|file| file.metadata().unwrap().len());
    let sizes: Vec<u64> = sizes.collect();
    let sum: u64 = sizes.iter().sum();
    assert_eq!(sizes.len(), 2 * Analytic::ALL.len() + 2);
    assert!(sum <= MOST_BYTES, "{sum} bytes");
}

/// DirectVoxGO's model goes through the hardware's formats as a trained one
/// does.
#[test]
fn the_dvgo_model_is_rendered_in_codes() {
    let mut scene = crate::tests::opened("cairn:dvgo");
    scene.set_size(Some(40), Some(40)).unwrap();
    let config =
        Config::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join("../../configs/fields.toml"))
            .unwrap();
    let mut units = ReferenceUnits::new(&config);
    let fixed = scene.render_fixed(&config, &mut units).unwrap().picture;
    let float = scene.render_float().unwrap().picture;
    let psnr = fixed.psnr(&float, |_| true).unwrap();
    println!("{psnr:.1} dB");
    // What was measured, less 3 dB.
    assert!(psnr > 74.8, "{psnr} dB");
}

/// A full-size model has the original's sizes, and shows its scene, since what is visible decides the
/// counts. Floors are what was measured against the ready model, less 1 dB; Instant-NGP's is grey, so
/// that only the covered pixels are compared.
#[test]
fn models_of_the_originals_sizes_have_them_and_show_their_scene() {
    let dvgo = scene("cairn:dvgo-full");
    let [(points, rows, 13)] = tables(&dvgo)[..] else {
        unreachable!()
    };
    let share = rows as f64 / 160f64.powi(3);
    assert!((share - 1.0).abs() < 0.02, "{points:?}");
    floors(&dvgo, "cairn:dvgo", 45.0);

    let tensorf = scene("cairn:tensorf-full");
    let own = tables(&tensorf);
    assert_eq!(own.iter().map(|t| t.2).sum::<usize>(), 2 * 192);
    assert!(own[..3].iter().all(|t| t.0 == [300, 300, 1]));
    assert!(own[3..].iter().all(|t| t.0 == [300, 1, 1]));
    floors(&tensorf, "cairn:tensorf", 58.5);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn larger_models_of_the_originals_sizes_have_them_and_show_their_scene() {
    let splats = scene("cairn:splats-300k");
    has_gaussians(&splats, 3e5);
    floors(&splats, "cairn:splats", 32.4);

    let ngp = scene("cairn:ngp-full");
    let own = tables(&ngp);
    assert!(own.len() == 16 && own.iter().all(|t| t.2 == 2));
    assert_eq!(own.iter().filter(|t| t.1 == 1 << 19).count(), 11);
    assert_eq!(own[15].0, [2049; 3]);
    let covered = |scene: &Scene| scene.render_float().unwrap().covered;
    let [full, ready] = [covered(&ngp), covered(&scene("cairn:ngp"))];
    let other = full.iter().zip(&ready).filter(|(a, b)| a != b).count();
    println!("cairn:ngp-full: {other} pixels covered otherwise");
    let pixels = full.len();
    assert!(other * 1000 <= pixels, "{other} of {pixels} pixels");
}

/// A model of the original's size is as near to the ready one as was measured.
fn floors(full: &Scene, ready: &str, floor: f64) {
    let [found, ready] = [full, &scene(ready)].map(|scene| scene.render_float().unwrap().picture);
    let psnr = found.psnr(&ready, |_| true).unwrap();
    println!("{}: {psnr:.1} dB", full.name());
    assert!(psnr > floor, "{}: {psnr} dB, floor {floor}", full.name());
}

/// Vertices along each axis, rows and channels of a field's tables.
fn tables(scene: &Scene) -> Vec<([usize; 3], usize, usize)> {
    let Model::Field(field) = scene.model() else {
        unreachable!("{}", scene.name())
    };
    let all = field.tables().iter();
    all.map(|t| (t.points(), t.rows(), t.channels())).collect()
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn three_million_gaussians_are_as_many() {
    has_gaussians(&scene("moons:splats-3m"), 3e6);
}

/// Each is replaced by a whole number of others.
fn has_gaussians(scene: &Scene, expected: f64) {
    let Model::Splats(cloud) = scene.model() else {
        unreachable!("{}", scene.name())
    };
    let share = cloud.len() as f64 / expected;
    assert!(
        (0.75..1.34).contains(&share),
        "{}: {}",
        scene.name(),
        cloud.len()
    );
    assert_eq!(cloud.degree(), 3);
}

#[test]
fn models_are_the_same_every_time() {
    are_the_same_every_time(&["moons:voxels", "moons:dvgo"]);
}

#[test]
#[ignore = "exhaustive; run with make test-full"]
fn splats_and_factors_are_the_same_every_time() {
    are_the_same_every_time(&["moons:splats", "moons:tensorf"]);
}

fn are_the_same_every_time(names: &[&str]) {
    for name in names {
        let [once, again] = [(); 2].map(|()| Scene::open(name).unwrap());
        assert_eq!(once.model(), again.model(), "{name}");
    }
}
