//! Interpolation weights, U1.W, that sum to exactly 1.
//!
//! Weights rounded one by one do not sum to 1, and a constant field does not
//! come back. Here a sum is split instead: `s` into `s - hi` and `hi`, with
//! `hi = floor(s u + 1/2)`, an axis at a time, the last axis first. That takes
//! six multiplies a sample, which all channels share.

/// Fraction bits of a position inside a cell, U1.12.
pub const FRACTION_BITS: u32 = 12;

/// Splits each of the first `count` sums in two, in place.
fn split(sums: &mut [u16], count: usize, fraction: u16) {
    let fraction = u32::from(fraction).min(1 << FRACTION_BITS);
    for i in (0..count).rev() {
        let s = u32::from(sums[i]);
        let hi = (s * fraction + (1 << (FRACTION_BITS - 1))) >> FRACTION_BITS;
        sums[2 * i] = (s - hi) as u16;
        sums[2 * i + 1] = hi as u16;
    }
}

fn one(weight_bits: u32) -> u16 {
    1 << weight_bits.min(15)
}

/// Weights of the two ends of an edge, U1.W with `W = weight_bits` of at most
/// 15, at the U1.12 fraction `u` of the way. A fraction above 1 counts as 1.
#[must_use]
pub fn linear(u: u16, weight_bits: u32) -> [u16; 2] {
    let mut sums = [one(weight_bits), 0];
    split(&mut sums, 1, u);
    sums
}

/// Weights of a face's corners; bit 0 of the corner's index is x, bit 1 y.
/// Otherwise as [`linear`].
#[must_use]
pub fn bilinear([x, y]: [u16; 2], weight_bits: u32) -> [u16; 4] {
    let mut sums = [one(weight_bits), 0, 0, 0];
    split(&mut sums, 1, y);
    split(&mut sums, 2, x);
    sums
}

/// Weights of a cell's corners; bit 0 of the corner's index is x, bit 1 y,
/// bit 2 z. Otherwise as [`linear`].
#[must_use]
pub fn trilinear([x, y, z]: [u16; 3], weight_bits: u32) -> [u16; 8] {
    let mut sums = [one(weight_bits), 0, 0, 0, 0, 0, 0, 0];
    split(&mut sums, 1, z);
    split(&mut sums, 2, y);
    split(&mut sums, 4, x);
    sums
}
