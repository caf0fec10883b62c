//! Reproducible noise: values of an integer hash at the corners of a unit grid, interpolated
//! smoothly.

use glam::DVec3;

/// One step of the hash: the finaliser of SplitMix64 applied to a coordinate.
fn mix(seed: u64, v: i64) -> u64 {
    let mut h = (seed ^ v as u64).wrapping_add(0x9e37_79b9_7f4a_7c15);
    h = (h ^ (h >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    h = (h ^ (h >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    h ^ (h >> 31)
}

fn unit(h: u64) -> f64 {
    (h >> 11) as f64 / (1u64 << 53) as f64
}

/// A number in [0, 1) for a corner of the unit grid.
pub(super) fn hash(x: i64, y: i64, z: i64) -> f64 {
    unit(mix(mix(mix(0, x), y), z))
}

/// Smooth noise in [0, 1) with features a unit across.
pub(super) fn value(p: DVec3) -> f64 {
    let cell = p.floor();
    let f = p - cell;
    let fade = f * f * (DVec3::splat(3.0) - 2.0 * f);
    let [x, y, z] = cell.to_array().map(|v| v as i64);
    let between = |a: f64, b: f64, t: f64| a + (b - a) * t;
    // As `hash` has it; corners share the steps of the coordinates they share.
    let columns = [x, x + 1].map(|x| mix(0, x));
    let row = |y, z| {
        let [a, b] = columns.map(|column| unit(mix(mix(column, y), z)));
        between(a, b, fade.x)
    };
    let sheet = |z| between(row(y, z), row(y + 1, z), fade.y);
    between(sheet(z), sheet(z + 1), fade.z)
}

/// Octaves of [`value`], each of half the size and half the height, in [0, 1).
pub(super) fn octaves(p: DVec3, count: u32) -> f64 {
    let (mut sum, mut height, mut all) = (0.0, 1.0, 0.0);
    let mut at = p;
    for _ in 0..count {
        sum += height * value(at);
        all += height;
        height *= 0.5;
        // Off the grid of the octave before, or their corners would coincide.
        at = at * 2.0 + DVec3::new(17.3, 5.1, 11.7);
    }
    sum / all
}
