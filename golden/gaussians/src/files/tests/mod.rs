//! Files written by other programs from a cloud that is reconstructed here.
#![allow(clippy::unwrap_used, clippy::panic)]

mod added;
mod agree;
mod fuzz;
mod gltf;
mod ksplat;
mod levels;
mod near;
pub mod pack;
mod refuse;
mod sog_images;
mod splat_rows;

use std::path::PathBuf;

use super::*;
use crate::{Cloud, CloudError};
use potamoi_base::sh;

/// Gaussians of the fixtures.
const COUNT: usize = 300;

/// A file of `golden/tests/fixtures/splats`, which `tools/splat-fixtures` makes.
fn fixture(name: &str) -> Vec<u8> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/fixtures/splats");
    std::fs::read(PathBuf::from(folder).join(name)).unwrap()
}

/// The fixtures and what reads them.
type Parse = fn(&[u8], &str) -> Result<Cloud, FileError>;
const FIXTURES: [(&str, Parse); 9] = [
    ("cloud.compressed.ply", packed_cloud),
    ("cloud.v2.spz", spz_cloud),
    ("cloud.v3.spz", spz_cloud),
    ("cloud.v4.spz", spz_cloud),
    ("cloud.sog", sog_cloud),
    ("cloud.0.ksplat", ksplat_cloud),
    ("cloud.1.ksplat", ksplat_cloud),
    ("cloud.2.ksplat", ksplat_cloud),
    ("few.glb", gltf_cloud),
];

fn packed_cloud(bytes: &[u8], origin: &str) -> Result<Cloud, FileError> {
    packed_ply::parse(bytes, origin).map(|loaded| loaded.cloud)
}

fn spz_cloud(bytes: &[u8], origin: &str) -> Result<Cloud, FileError> {
    spz::parse(bytes, origin).map(|loaded| loaded.cloud)
}

fn sog_cloud(bytes: &[u8], origin: &str) -> Result<Cloud, FileError> {
    sog::parse(bytes, origin).map(|loaded| loaded.cloud)
}

fn ksplat_cloud(bytes: &[u8], origin: &str) -> Result<Cloud, FileError> {
    super::ksplat::parse(bytes, origin).map(|loaded| loaded.cloud)
}

fn gltf_cloud(bytes: &[u8], origin: &str) -> Result<Cloud, FileError> {
    super::gltf::parse(bytes, Path::new(""), origin).map(|loaded| loaded.cloud)
}

fn splat_cloud(bytes: &[u8], origin: &str) -> Result<Cloud, FileError> {
    splat::parse(bytes, origin).map(|loaded| loaded.cloud)
}

fn read_cloud(path: &Path) -> Result<Cloud, FileError> {
    read(path, None).map(|loaded| loaded.cloud)
}

/// Property `p` of Gaussian `i`: 12 bits of a hash over a range.
fn value(i: usize, p: usize) -> f32 {
    const OPACITY: usize = 6;
    if p == OPACITY && i % 50 < 2 {
        return if i.is_multiple_of(50) { 20.0 } else { -20.0 };
    }
    let (low, span) = match p {
        0..3 => (-2.0, 4.0),
        3..6 | 10..14 => (-1.0, 2.0),
        OPACITY => (-4.0, 8.0),
        7..10 => (-6.0, 4.0),
        _ => (-0.5, 1.0),
    };
    let mut h = (i as u32)
        .wrapping_mul(0x9e37_79b1)
        .wrapping_add((p as u32 + 1).wrapping_mul(0x85eb_ca77));
    h = (h ^ h >> 15).wrapping_mul(0xc2b2_ae3d);
    h = (h ^ h >> 13).wrapping_mul(0x27d4_eb2f);
    low + (h >> 20) as f32 * span / 4096.0
}

/// The cloud that the fixtures were written from, of degree 3.
fn original() -> Cloud {
    let all = 0..COUNT;
    let three = |i: usize, p: usize| [value(i, p), value(i, p + 1), value(i, p + 2)];
    let rotation = |i: usize| [10, 11, 12, 13].map(|p| value(i, p));
    let rest = |i: usize, k: usize| [0, 15, 30].map(|c| value(i, 14 + c + k));
    Cloud::new(
        3,
        all.clone().map(|i| three(i, 0)).collect(),
        all.clone().map(|i| three(i, 7)).collect(),
        all.clone().map(rotation).collect(),
        all.clone().map(|i| value(i, 6)).collect(),
        all.flat_map(|i| std::iter::once(three(i, 3)).chain((0..15).map(move |k| rest(i, k))))
            .collect(),
    )
    .unwrap()
}
