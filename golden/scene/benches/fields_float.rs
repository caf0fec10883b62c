//! Benchmark of the floating-point renderer of fields: gathered samples a second of processor time.
//!
//! Scenes: the built-in cairn as DirectVoxGO, Instant-NGP and TensoRF, and as a voxel grid, at 200 x
//! 200. A gathered sample is one where the field is not known to be empty, up to where its ray
//! stops; empty samples on the way take time and do not count.
//!
//! *Processor time* is the computing time of all threads together (on Linux; elsewhere elapsed time
//! times threads). Unlike elapsed time it is stable on a busy machine. `RAYON_NUM_THREADS` sets the
//! number of threads.
#![allow(missing_docs, clippy::expect_used, clippy::panic)]

use std::time::{Duration, Instant};

use potamoi_fields::{FloatOptions, render_masked};
use potamoi_scene::{Model, Scene};

const SCENES: [&str; 4] = ["cairn:dvgo", "cairn:ngp", "cairn:tensorf", "cairn"];
const WIDTH: u32 = 200;
const FRAMES: usize = 7;

/// Processor time of all threads so far, if the system reports it.
fn processor() -> Option<Duration> {
    let mut sum = 0;
    for thread in std::fs::read_dir("/proc/self/task").ok()? {
        let stat = std::fs::read_to_string(thread.ok()?.path().join("schedstat")).ok()?;
        sum += stat.split(' ').next()?.parse::<u64>().ok()?;
    }
    Some(Duration::from_nanos(sum))
}

fn main() {
    // With `--test`, one small frame each: that it runs.
    let is_test = std::env::args().any(|arg| arg == "--test");
    let (width, frames) = if is_test { (16, 1) } else { (WIDTH, FRAMES) };
    for name in SCENES {
        let mut scene = Scene::open(name).expect("a built-in scene");
        scene.set_size(Some(width), None).expect("a size");
        let Model::Field(field) = scene.model() else {
            panic!("{name} is a field");
        };
        let frame = || {
            let (start, before) = (Instant::now(), processor());
            let frame = render_masked(&**field, scene.camera(), &FloatOptions::default(), None);
            let frame = frame.expect("a frame");
            let elapsed = start.elapsed() * rayon::current_num_threads() as u32;
            let spent = before.and_then(|before| processor()?.checked_sub(before));
            (spent.unwrap_or(elapsed), frame)
        };
        let (best, frame) = (0..frames)
            .map(|_| frame())
            .min_by_key(|(spent, _)| *spent)
            .expect("a frame");
        println!(
            "{name:14} {width} x {width}: {:8.1} ms of processor time, {} samples, {} gathered, {} \
             coloured; {:.3} M gathered a second",
            best.as_secs_f64() * 1e3,
            frame.samples,
            frame.gathered,
            frame.coloured,
            frame.gathered as f64 / best.as_secs_f64() / 1e6,
        );
    }
}
