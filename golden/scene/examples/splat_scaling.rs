//! Time of a float frame of splats by Gaussians, pixels and threads, as rows of CSV.
//!
//! `splat_scaling MODEL CAMERA` measures, `splat_scaling MODEL COUNT OUT.ply` writes a model of COUNT
//! Gaussians: the Gaussians of MODEL again and again with their constant colours, each copy moved by
//! at most a hundredth of the model's extent. Measured models are the same.
#![allow(missing_docs)]

use std::error::Error;
use std::io::Write as _;
use std::path::Path;
use std::time::{Duration, Instant};

use potamoi_base::camera::Camera;
use potamoi_base::file_keys::Notes;
use potamoi_gaussians::Cloud;
use potamoi_scene::{Model, Scene, camera_file};
use potamoi_splats::{FloatOptions, Profile, render_float};

/// Gaussians, sides of the picture, and threads. One of them changes at a time, from these.
const GAUSSIANS: [usize; 5] = [100_000, 250_000, 500_000, 1_000_000, 2_000_000];
const SIDES: [u32; 4] = [200, 400, 800, 1600];
const BASE: (usize, u32) = (500_000, 800);
/// Frames of which the fastest counts.
const FRAMES: usize = 5;
/// Steps of the three additive sequences of moves, irrational to each other (Roberts's R3).
const STEPS: [f64; 3] = [
    0.819_172_513_396_164_4,
    0.671_043_606_703_789_3,
    0.549_700_477_901_910_4,
];

/// `count` Gaussians of copies of a model.
fn copies(model: &Cloud, count: usize) -> Result<Cloud, Box<dyn Error>> {
    let [low, high] = model.bounds();
    let moved = |i: usize| {
        let (copy, own) = (i / model.len(), model.means()[i % model.len()]);
        let part = |axis: usize| match copy {
            0 => 0.0,
            copy => (copy as f64 * STEPS[axis]).fract() - 0.5,
        };
        [0, 1, 2].map(|axis| own[axis] + (high[axis] - low[axis]) * 0.02 * part(axis) as f32)
    };
    let source = |i: usize| i % model.len();
    Ok(Cloud::new(
        0,
        (0..count).map(moved).collect(),
        (0..count).map(|i| model.log_scales()[source(i)]).collect(),
        (0..count).map(|i| model.rotations()[source(i)]).collect(),
        (0..count)
            .map(|i| model.opacity_logits()[source(i)])
            .collect(),
        (0..count).map(|i| model.sh(source(i))[0]).collect(),
    )?)
}

fn write(cloud: &Cloud, path: &Path) -> Result<(), Box<dyn Error>> {
    let mut out = std::io::BufWriter::new(std::fs::File::create(path)?);
    writeln!(
        out,
        "ply\nformat binary_little_endian 1.0\nelement vertex {}",
        cloud.len()
    )?;
    let names =
        "x y z f_dc_0 f_dc_1 f_dc_2 opacity scale_0 scale_1 scale_2 rot_0 rot_1 rot_2 rot_3";
    for name in names.split(' ') {
        writeln!(out, "property float {name}")?;
    }
    writeln!(out, "end_header")?;
    for i in 0..cloud.len() {
        let opacity = [cloud.opacity_logits()[i]];
        let parts: [&[f32]; 5] = [
            &cloud.means()[i],
            &cloud.sh(i)[0],
            &opacity,
            &cloud.log_scales()[i],
            &cloud.rotations()[i],
        ];
        for value in parts.into_iter().flatten() {
            out.write_all(&value.to_le_bytes())?;
        }
    }
    out.flush()?;
    Ok(())
}

/// Processor time of all threads so far, where the system reports it.
fn processor() -> Option<Duration> {
    let mut sum = 0;
    for thread in std::fs::read_dir("/proc/self/task").ok()? {
        let stat = std::fs::read_to_string(thread.ok()?.path().join("schedstat")).ok()?;
        sum += stat.split(' ').next()?.parse::<u64>().ok()?;
    }
    Some(Duration::from_nanos(sum))
}

/// Least elapsed and processor milliseconds of a frame.
fn measured(cloud: &Cloud, camera: &Camera, threads: usize) -> Result<[f64; 2], Box<dyn Error>> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads)
        .build()?;
    let mut best = [f64::MAX; 2];
    for _ in 0..FRAMES {
        let (start, before) = (Instant::now(), processor().unwrap_or_default());
        let frame = || render_float(cloud, camera, Profile::Inria, &FloatOptions::default());
        std::hint::black_box(pool.install(frame)?);
        let spent = processor().unwrap_or_default() - before;
        let took = [start.elapsed(), spent].map(|own| 1e3 * own.as_secs_f64());
        best = [0, 1].map(|i| best[i].min(took[i]));
    }
    Ok(best)
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let usage = "splat_scaling MODEL CAMERA, or splat_scaling MODEL COUNT OUT.ply";
    let scene = Scene::open(arguments.first().ok_or(usage)?)?;
    let Model::Splats(model) = scene.model() else {
        return Err("expected a model of Gaussians".into());
    };
    if let [_, count, path] = &arguments[..] {
        return write(&copies(model, count.parse()?)?, Path::new(path));
    }
    let [_, camera] = &arguments[..] else {
        return Err(usage.into());
    };
    let cameras = camera_file::read(Path::new(camera), &mut Notes::default())?;
    let camera = cameras.first().ok_or("expected a camera")?.camera;
    let most = std::thread::available_parallelism()?.get();
    println!("changed,gaussians,side,threads,elapsed_ms,processor_ms");
    let row = |changed: &str, gaussians: usize, side: u32, threads: usize| {
        let cloud = copies(model, gaussians)?;
        let [elapsed, spent] = measured(&cloud, &camera.resized(side, side), threads)?;
        println!("{changed},{gaussians},{side},{threads},{elapsed:.2},{spent:.2}");
        Ok::<(), Box<dyn Error>>(())
    };
    for gaussians in GAUSSIANS {
        row("Gaussians", gaussians, BASE.1, most)?;
    }
    for side in SIDES {
        row("pixels", BASE.0, side, most)?;
    }
    for threads in 1..=most {
        row("threads", BASE.0, BASE.1, threads)?;
    }
    Ok(())
}
