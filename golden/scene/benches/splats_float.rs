//! Benchmark of the float splat renderer, from Gaussians to picture, against the machine's peak.
//!
//! Scenes: the built-in garden, at its own size and at 800 x 800; `dense`, whose Gaussians each
//! fill the frame, so that only the arithmetic of pixels counts; and two published scenes of the
//! shared data (`POTAMOI_SHARED`, or `../shared` beside the checkout), skipped with a message if
//! they are missing.
//!
//! *Processor time* is the computing time of all threads together (on Linux; elsewhere elapsed
//! time times threads). Unlike elapsed time it is stable on a busy machine. Divided by the number
//! of cores it is the elapsed time of a quiet machine.
//!
//! An *evaluation* is one Gaussian at one pixel: [`OPERATIONS`] 64-bit additions and
//! multiplications. *Peak* is the number of these that a processor executes a second if they come
//! in equal numbers, from registers and without dependencies, in the same vectors as the renderer's;
//! it is measured just before. The fraction of peak counts only evaluations. Comparisons, selections,
//! projection, sorting, finding spans and moving data do not count; `dense` shows the cost without
//! the last four.
//!
//! `RAYON_NUM_THREADS` sets the number of threads.
#![allow(missing_docs, clippy::expect_used, clippy::panic)]

use std::cell::Cell;
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use criterion::{Criterion, Throughput};
use fearless_simd::dispatch;
use fearless_simd::prelude::*;
use glam::DVec3;
use potamoi_base::camera::Camera;
use potamoi_base::file_keys::Notes;
use potamoi_scene::{Model, Scene, camera_file, garden};
use potamoi_splats::{Cloud, FloatOptions, Profile, Vectors, render_float};

/// Additions and multiplications of an evaluation: 7 for the square, 32 for the exponential, 4 for
/// alpha and transmittance, 6 for the colour.
const OPERATIONS: u64 = 49;
/// Independent values in the peak's loop: enough to hide latencies, few enough for the registers
/// of the smallest machine.
const CHAINS: usize = 12;
const ROUNDS: u64 = 600_000_000;
/// Frames with each of the processor's vectors, of which the fastest counts.
const FRAMES: usize = 8;
/// Number of Gaussians in `dense`.
const LAYERS: usize = 100;

/// Processor time of all threads so far, if the system reports it.
fn processor() -> Option<Duration> {
    let mut sum = 0;
    for thread in std::fs::read_dir("/proc/self/task").ok()? {
        let stat = std::fs::read_to_string(thread.ok()?.path().join("schedstat")).ok()?;
        sum += stat.split(' ').next()?.parse::<u64>().ok()?;
    }
    Some(Duration::from_nanos(sum))
}

/// Elapsed and processor time of `work` on `threads` threads.
fn time(threads: usize, work: impl FnOnce()) -> [Duration; 2] {
    let (start, before) = (Instant::now(), processor());
    work();
    let elapsed = start.elapsed();
    let spent = before.and_then(|b| processor()?.checked_sub(b));
    [elapsed, spent.unwrap_or(elapsed * threads as u32)]
}

/// Additions and multiplications a second of processor time with these vectors, none of them fused.
fn peak(vectors: Vectors) -> f64 {
    let level = vectors.level().expect("vectors of this processor");
    let best = (0..5).map(|_| time(1, || dispatch!(level, simd => chains(simd)))[1]);
    let lanes = dispatch!(level, simd => lanes(simd)) as u64;
    2.0 * (ROUNDS * lanes) as f64 / best.min().expect("five").as_secs_f64()
}

#[inline(always)]
fn lanes<S: Simd>(_: S) -> usize {
    S::f64s::LEN
}

#[inline(always)]
fn chains<S: Simd>(simd: S) {
    let splat = |value: f64| S::f64s::splat(simd, black_box(value));
    let mut values: [S::f64s; CHAINS] = std::array::from_fn(|i| splat(i as f64));
    let (factor, term) = (splat(0.999), splat(0.001));
    for _ in 0..ROUNDS / CHAINS as u64 {
        for value in &mut values {
            *value = *value * factor + term;
        }
    }
    black_box(values.map(|value| value.to_array()));
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
    let cameras =
        camera_file::read(&data.join(camera), &mut Notes::default()).expect("a camera file");
    match Scene::open(data.join(file).to_str()?) {
        Ok(scene) => match scene.model() {
            Model::Splats(cloud) => Some((cloud.clone(), cameras[0].camera)),
            _ => panic!("{file} holds splats"),
        },
        Err(error) => {
            println!("skipped: {name}: {error}");
            None
        }
    }
}

fn main() {
    let shared = std::env::var_os("POTAMOI_SHARED").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../../shared")),
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
        let Some(widest) = Vectors::widest() else {
            panic!("this processor has no vectors that the renderer knows");
        };
        let best_peak = peak(widest);
        let options = FloatOptions::default();
        let by = |options: FloatOptions| {
            render_float(&cloud, &camera, Profile::Inria, &options).expect("a frame")
        };
        let render = || by(options);
        let logged = by(FloatOptions {
            log_decisions: true,
            ..options
        });
        let stats = logged.stats.expect("a log");
        let threads = rayon::current_num_threads();
        let best = Cell::new([Duration::MAX; 2]);
        group.throughput(Throughput::Elements(stats.evaluated));
        group.bench_function(name, |b| {
            b.iter_custom(|frames| {
                let mut total = Duration::ZERO;
                for _ in 0..frames {
                    let took = time(threads, || {
                        black_box(render());
                    });
                    best.set([0, 1].map(|i| best.get()[i].min(took[i])));
                    total += took[0];
                }
                total
            });
        });
        let [elapsed, spent] = best.get().map(|d| d.as_secs_f64());
        if best.get()[0] == Duration::MAX {
            continue; // Not chosen on the command line.
        }
        let rate = stats.evaluated as f64 / spent;
        println!(
            "{name}: {} Gaussians, {} x {} pixels, {threads} threads: at best {:.1} ms elapsed, \
             {:.1} ms of processor time; {:.1} million evaluations ({:.1} drawn), \
             {:.0} million a second of it, {:.0} % of the peak of {:.1} G operations a second\n",
            stats.visible,
            camera.width,
            camera.height,
            1e3 * elapsed,
            1e3 * spent,
            stats.evaluated as f64 / 1e6,
            stats.drawn as f64 / 1e6,
            rate / 1e6,
            100.0 * rate * OPERATIONS as f64 / best_peak,
            best_peak / 1e9
        );
        for vectors in Vectors::here() {
            let options = FloatOptions {
                vectors: Some(vectors),
                ..options
            };
            let frame = || time(threads, || drop(black_box(by(options))));
            let best = (0..FRAMES).map(|_| frame()[1]).min().expect("frames");
            println!(
                "{name}, {vectors}: {:.1} ms of processor time",
                1e3 * best.as_secs_f64()
            );
        }
    }
    group.finish();
    criterion.final_summary();
}
