//! Benchmark of meshes: marching cubes of a built-in scene, and depth from a mesh. Elements are
//! cells for extraction and triangles for drawing.
#![allow(missing_docs, clippy::expect_used)]

use std::hint::black_box;

use criterion::{Criterion, Throughput};
use potamoi_scene::Scene;
use potamoi_scene::surface::of_scene;

fn main() {
    let mut criterion = Criterion::default().sample_size(10).configure_from_args();
    let scene = Scene::open("cairn").expect("built in");
    let mut group = criterion.benchmark_group("mesh");
    for cells in [128u32, 256] {
        let make = || of_scene(&scene, cells).expect("a mesh");
        group.throughput(Throughput::Elements(u64::from(cells).pow(3)));
        group.bench_function(format!("of_cairn_{cells}"), |b| {
            b.iter(|| black_box(make()))
        });
        let mesh = make();
        let triangles = mesh.triangles().len() as u64;
        for side in [200, 800] {
            let camera = scene.camera().resized(side, side);
            group.throughput(Throughput::Elements(triangles));
            group.bench_function(format!("depth_{cells}_at_{side}"), |b| {
                b.iter(|| black_box(mesh.depth(&camera)));
            });
        }
    }
    group.finish();
    criterion.final_summary();
}
