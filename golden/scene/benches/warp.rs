//! Benchmark of warping a million points, against the time of the memory traffic alone.
#![allow(missing_docs)]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::DVec3;
use potamoi_base::camera::Camera;
use potamoi_base::picture::Picture;
use potamoi_warp::{Shaded, reproject};

const SIDE: u32 = 1000;

fn camera(turn: f64) -> Camera {
    let eye = 3.0 * DVec3::new(turn.sin(), 0.1, -turn.cos());
    Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.8, SIDE, SIDE)
}

/// A hilly wall: every pixel is a point.
fn reference() -> Shaded {
    let depth = (0..SIDE * SIDE).map(|i| {
        let [x, y] = [i % SIDE, i / SIDE].map(|v| v as f32 / 40.0);
        3.0 + 0.1 * (x.sin() + y.cos())
    });
    Shaded {
        picture: Picture::filled(SIDE, SIDE, [0.5; 3]),
        depth: depth.collect(),
    }
}

fn warp(c: &mut Criterion) {
    let reference = reference();
    let (from, to) = (camera(0.0), camera(0.03));
    let mut group = c.benchmark_group("warp");
    group.throughput(Throughput::Elements(u64::from(SIDE * SIDE)));
    group.bench_function("million points", |b| {
        b.iter(|| black_box(reproject(&reference, &from, &to)));
    });
    // What has to be moved at least: depths in, points out.
    let bytes = vec![1u8; (SIDE * SIDE) as usize * 4];
    let mut out = vec![0u8; (SIDE * SIDE) as usize * 12];
    group.bench_function("its memory, copied", |b| {
        b.iter(|| {
            for part in out.chunks_exact_mut(bytes.len()) {
                part.copy_from_slice(black_box(&bytes));
            }
            black_box(&mut out);
        });
    });
    group.finish();
}

criterion_group!(benches, warp);
criterion_main!(benches);
