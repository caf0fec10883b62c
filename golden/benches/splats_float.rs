//! Speed of the float renderer of splats, from Gaussians to picture, beside
//! what the machine could do.
//!
//! Scenes: the built-in garden, as it is and at 800 x 800; `dense`, Gaussians
//! that each fill the frame, so that nothing but the pixels' own arithmetic
//! counts; and two published scenes of the shared data (`POTAMOI_SHARED`, or
//! `../shared` beside the checkout), skipped with a message where they are
//! not there.
//!
//! An *evaluation* is one Gaussian at one pixel: [`OPERATIONS`] additions and
//! multiplications of 64 bits. *Peak* is how many of these the machine does a
//! second on as many threads when they come in equal numbers, from registers,
//! none waiting for another, compiled as the renderer is: measured here, just
//! before. The fraction of it counts evaluations alone. Comparisons,
//! selections, projection, sorting, finding spans and moving data count as
//! nothing done, so that `dense` shows what a perfect rest would reach.
//!
//! `RAYON_NUM_THREADS` sets the number of threads.
#![allow(missing_docs, clippy::expect_used, clippy::panic)]

use std::cell::Cell;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use criterion::{Criterion, Throughput};
use glam::DVec3;
use potamoi_golden::camera::Camera;
use potamoi_golden::scene::{Model, Scene, camera_file, garden};
use potamoi_golden::splats::{Cloud, FloatOptions, Profile, render_float};

/// Additions and multiplications of an evaluation: 7 for the square, 32 for
/// the exponential, 4 for alpha and transmittance, 6 for the colour.
const OPERATIONS: u64 = 49;
/// Independent values of the peak's loop: enough to hide latencies, few enough
/// for the registers of the least machine.
const CHAINS: usize = 24;
const ROUNDS: u64 = 20_000_000;
/// Gaussians of `dense`.
const LAYERS: usize = 100;

/// Additions and multiplications a second on all threads.
fn peak() -> f64 {
    let once = || {
        let start = Instant::now();
        rayon::broadcast(|_| {
            let mut values: [f64; CHAINS] = std::array::from_fn(|i| black_box(i as f64));
            let (factor, term) = (black_box(0.999), black_box(0.001));
            for _ in 0..ROUNDS / CHAINS as u64 {
                for v in &mut values {
                    *v = *v * factor + term;
                }
            }
            black_box(values);
        });
        start.elapsed()
    };
    let best = (0..5).map(|_| once()).min().expect("five");
    let done = 2 * ROUNDS * rayon::current_num_threads() as u64;
    done as f64 / best.as_secs_f64()
}

fn dense() -> (Cloud, Camera) {
    let depth = |i| 1.0 + i as f32 / LAYERS as f32;
    let cloud = Cloud::new(
        0,
        (0..LAYERS).map(|i| [0.0, 0.0, depth(i)]).collect(),
        vec![[8.0; 3]; LAYERS],
        vec![[1.0, 0.0, 0.0, 0.0]; LAYERS],
        vec![-4.5; LAYERS],
        vec![[0.5; 3]; LAYERS],
    );
    let camera = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 0.9, 400, 400);
    (cloud.expect("a cloud"), camera)
}

/// A published scene and its camera.
fn published(data: Option<&Path>, name: &str, file: &str) -> Option<(Cloud, Camera)> {
    let camera = format!("cameras/camera_{name}_800.json");
    let Some(data) = data.filter(|d| d.join(file).is_file() && d.join(&camera).is_file()) else {
        println!("skipped: {name}: no shared data (set POTAMOI_SHARED)");
        return None;
    };
    let cameras = camera_file::read(&data.join(camera)).expect("a camera file");
    match Scene::open(data.join(file).to_str()?) {
        Ok(scene) => match scene.model() {
            Model::Splats(cloud) => Some((cloud.clone(), cameras[0].camera)),
            Model::Voxels(_) | Model::Dvgo(_) => panic!("{file} holds splats"),
        },
        Err(error) => {
            println!("skipped: {name}: {error}");
            None
        }
    }
}

fn main() {
    let shared = std::env::var_os("POTAMOI_SHARED").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared")),
        PathBuf::from,
    );
    let data = Some(shared.join("data")).filter(|d| d.is_dir());
    let data = data.as_deref();
    let garden = || (garden::cloud(), garden::camera());
    let large = || (garden::cloud(), garden::camera().resized(800, 800));
    let scenes = [
        ("dense", Some(dense())),
        ("garden", Some(garden())),
        ("garden_800", Some(large())),
        (
            "biker",
            published(data, "biker", "splats/biker/biker.compressed.ply"),
        ),
        (
            "playbot_31k",
            published(data, "playbot_31k", "splats/playbot_31k.ply"),
        ),
    ];

    let mut criterion = Criterion::default()
        .sample_size(10)
        .measurement_time(Duration::from_secs(5))
        .configure_from_args();
    let mut group = criterion.benchmark_group("splats_float");
    for (name, scene) in scenes {
        let Some((cloud, camera)) = scene else {
            continue;
        };
        let peak = peak();
        let options = FloatOptions::default();
        let render = || render_float(&cloud, &camera, Profile::Inria, &options).expect("a frame");
        let stats = render().stats;
        let best = Cell::new(Duration::MAX);
        group.throughput(Throughput::Elements(stats.evaluated));
        group.bench_function(name, |b| {
            b.iter_custom(|frames| {
                let mut total = Duration::ZERO;
                for _ in 0..frames {
                    let start = Instant::now();
                    black_box(render());
                    let took = start.elapsed();
                    best.set(best.get().min(took));
                    total += took;
                }
                total
            });
        });
        if best.get() == Duration::MAX {
            continue; // Not chosen on the command line.
        }
        let seconds = best.get().as_secs_f64();
        let rate = stats.evaluated as f64 / seconds;
        println!(
            "{name}: {} Gaussians, {} x {} pixels, {} threads: {:.1} ms at best, \
             {:.1} million evaluations ({:.1} drawn), {:.0} million a second, \
             {:.0} % of the peak of {:.2} G operations a second\n",
            stats.visible,
            camera.width,
            camera.height,
            rayon::current_num_threads(),
            1e3 * seconds,
            stats.evaluated as f64 / 1e6,
            stats.drawn as f64 / 1e6,
            rate / 1e6,
            100.0 * rate * OPERATIONS as f64 / peak,
            peak / 1e9
        );
    }
    group.finish();
    criterion.final_summary();
}
