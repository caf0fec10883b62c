//! The groups of a tile that a Gaussian can reach.
//!
//! Rows of 16 pixels are computed side by side in 32-bit floats. A span errs outwards by more than
//! rounding can move it, and every pixel decides by its own alpha, so that no decision depends on a
//! span. With `u = 2^-24`, the mean at (x, y) from the tile's first pixel, `s = L21 / L11` and the
//! row at `d` from the mean:
//!
//! - `q = L22 d` is off by `u (L22 |y| + 3 |q|)` at most. A row in reach has `|q| <= Q`, the root of the
//!   reach, so that `L22 |y| <= Q + 16 L22 < Q + 30`, and `q^2` is off by `u Q (9 Q + 60)`: below 1.8e-5
//!   for the largest reach, `Q^2 = 2 ln(1 / 4e-4)`. It is taken as 1e-3.
//! - The ends, `x - s d` plus or minus half a span `h`, are off by `6 u (|x| + |s y| + |s d| + h)` at
//!   most. It is taken as 1e-6 of the same sum, and a hundredth of a pixel.

use fearless_simd::f32x16;
use fearless_simd::prelude::*;

use super::group::{COLUMNS, SIDE};
use super::splats::Splat;

/// Rows of a column of groups with pixels that the Gaussian can reach, 16 bits for each of the
/// four columns.
#[inline(always)]
pub(super) fn reached<S: Simd>(simd: S, splat: &Splat, origin: [f64; 2]) -> u64 {
    let [x, y] = [0, 1].map(|axis| (splat.mean[axis] - origin[axis]) as f32);
    let [l11, l21, l22] = splat.factor.map(|l| l as f32);
    let inverse = 1.0 / l11;
    let slope = l21 * inverse;
    let rows: [f32; SIDE] = std::array::from_fn(|row| row as f32);
    let d = f32x16::simd_from(simd, rows) - y;
    let q = d * l22;
    let room = f32x16::splat(simd, splat.reach + 1e-3) - q * q;
    let shift = d * slope;
    let half = room.sqrt() * inverse;
    let fixed = 0.01 + 1e-6 * (x.abs() + (slope * y).abs());
    let half = half + (shift.abs() + half) * 1e-6 + fixed;
    let middle = f32x16::splat(simd, x) - shift;
    let from = (middle - half).ceil();
    let to = (middle + half).floor();
    // What is no number, of extreme needles, excludes nothing.
    let none = room.simd_lt(0.0) | from.simd_gt(to);
    let mut beside = 0;
    for column in 0..SIDE / COLUMNS {
        let first = (column * COLUMNS) as f32;
        let out = from.simd_gt(first + (COLUMNS - 1) as f32) | to.simd_lt(first);
        beside |= out.to_bitmask() << (column * SIDE);
    }
    !(beside | (none.to_bitmask() * 0x0001_0001_0001_0001))
}
