//! Groups of pixels that are composited together.

use fearless_simd::prelude::*;
use fearless_simd::{f64x4, f64x8};

use crate::view::TILE;

/// Pixels on a side of a tile.
pub(super) const SIDE: usize = TILE as usize;
/// Pixels of a row that are composited together.
pub(super) const COLUMNS: usize = 4;

/// A value for each pixel of one group, or of two, one below the other.
pub(super) trait Group<S: Simd>:
    SimdFloat<S, Element = f64, Bits: SimdInt<S, Element = u64>>
{
    /// The first rows of what holds the given rows of a column of groups.
    fn starts(rows: u16) -> u16;

    /// Four values of neighbouring columns, for each row.
    fn columns(simd: S, values: [f64; COLUMNS]) -> Self;

    /// The value of each row from `row` on, for all columns.
    fn rows(simd: S, values: &[f64; SIDE], row: usize) -> Self;
}

impl<S: Simd> Group<S> for f64x4<S> {
    #[inline(always)]
    fn starts(rows: u16) -> u16 {
        rows
    }

    #[inline(always)]
    fn columns(simd: S, values: [f64; COLUMNS]) -> Self {
        Self::simd_from(simd, values)
    }

    #[inline(always)]
    fn rows(simd: S, values: &[f64; SIDE], row: usize) -> Self {
        Self::splat(simd, values[row % SIDE])
    }
}

impl<S: Simd> Group<S> for f64x8<S> {
    #[inline(always)]
    fn starts(rows: u16) -> u16 {
        (rows | rows >> 1) & 0x5555
    }

    #[inline(always)]
    fn columns(simd: S, values: [f64; COLUMNS]) -> Self {
        let row = f64x4::simd_from(simd, values);
        simd.combine_f64x4(row, row)
    }

    #[inline(always)]
    fn rows(simd: S, values: &[f64; SIDE], row: usize) -> Self {
        let [a, b] = [values[row % SIDE], values[(row + 1) % SIDE]];
        simd.combine_f64x4(f64x4::splat(simd, a), f64x4::splat(simd, b))
    }
}
