//! The exponential of the renderer's inner loop, of all pixels of a vector at once.
//!
//! Straight-line arithmetic without calls or tables. No fused operation is used: every machine
//! gives the same bits, whatever the width of its vectors.

use fearless_simd::prelude::*;

use super::group::Group;

/// Lower arguments are clamped to this: the result is far too faint for any rule set.
const LEAST: f64 = -700.0;
/// Adding it leaves a rounded integer in the lowest bits of the sum.
pub(super) const ROUND: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52
/// ln 2 in two parts; the first has 21 zero bits at its end, so that its
/// product with the exponent of a result is exact.
pub(super) const LN_2: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];

/// The polynomial of degree 11 that interpolates e^r at the twelve Chebyshev nodes of |r| <= ln 2
/// / 2, from 60-digit arithmetic; before rounding its coefficients it is within 4.3e-18 of e^r
/// there.
pub(super) const POLYNOMIAL: [f64; 12] = [
    1.0,
    1.0,
    0.500_000_000_000_001_9,
    0.166_666_666_666_666_8,
    0.041_666_666_666_488_09,
    0.008_333_333_333_319_601,
    0.001_388_888_895_231_481_2,
    0.000_198_412_698_900_471_43,
    2.480_148_548_228_773e-5,
    2.755_724_091_854_762_5e-6,
    2.763_263_965_412_376e-7,
    2.511_003_761_756_205e-8,
];

/// e^x for x in -700..=0 with a relative error below 4e-16; below -700, e^-700 (1e-304). Not valid
/// for x above 700 or NaN.
#[inline(always)]
pub(super) fn exp<S: Simd, G: Group<S>>(x: G) -> G {
    let x = x.max(LEAST);
    let shifted = x * std::f64::consts::LOG2_E + ROUND;
    let power = shifted - ROUND;
    let r = (x - power * LN_2[0]) - power * LN_2[1];
    let c = &POLYNOMIAL;
    let r2 = r * r;
    let r4 = r2 * r2;
    let r8 = r4 * r4;
    // 1 + r last, so that its rounding is the only one of weight.
    let low = (r * c[3] + c[2]) * r2;
    let mid = ((r * c[5] + c[4]) + (r * c[7] + c[6]) * r2) * r4;
    let high = ((r * c[9] + c[8]) + (r * c[11] + c[10]) * r2) * r8;
    let value = (r + (low + (mid + high))) + 1.0;
    // The lowest 12 bits of `shifted` hold the power; the shift leaves them
    // alone, biased, as the exponent of a double.
    let scale = G::from_bits((shifted.to_bits() + 1023u64) << 52u32);
    value * scale
}
