//! Spans: the pixels of a tile that a Gaussian can reach, row by row.
//!
//! The unit finds them with a few bits. With `p` and `q` in units of 1/64, rounded down in
//! magnitude, a pair can count only if `p^2 + q^2 <= limit`, so only if `|p| <= floor(sqrt(limit -
//! q^2))`. Forms grow by a step a pixel; steps and start values are rounded down to 1/1024, so that
//! the form at any of 16 pixels is off by less than 16/1024. All errors widen the span: a pixel
//! outside never counts.

use potamoi_formats::record::{FACTOR, MEAN, SplatRecord};

use super::TILE;
use super::affine_forms::Forms;

/// A mask of all pixels of a row, or of all rows.
pub const ROW_MASK: u16 = u16::MAX;
/// Fraction bits of start values and steps in the search.
const SEARCH_BITS: u32 = 10;
/// Fraction bits of a form that is compared.
const COMPARE_BITS: u32 = 6;
/// Fraction bits of exact forms.
const EXACT_BITS: u32 = FACTOR.frac_bits() + MEAN.frac_bits();
/// Forms of this magnitude or more, with 16 fraction bits, count nowhere: u is 8.
const BEYOND: i32 = 4 << 16;

/// A row of a tile with the pixels that may count.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    /// The row, from 0.
    pub row: u32,
    /// The pixels, the first lowest.
    pub mask: u16,
}

/// The rows of a tile that a record may reach, and the pixels of each.
#[derive(Debug, Clone, Copy)]
pub struct Spans<'f> {
    forms: &'f Forms,
    step: [i64; 2],
    /// `p^2 + q^2` with 12 fraction bits is at most this.
    limit: i64,
}

/// The largest integer whose square is at most `n`; -1 for a negative `n`.
fn root(n: i64) -> i64 {
    if n < 0 { -1 } else { n.isqrt() }
}

impl<'f> Spans<'f> {
    /// The spans of a record whose power is at most `limit`, a code with `power_bits` fraction bits,
    /// at least 12.
    #[must_use]
    pub fn new(record: &SplatRecord, forms: &'f Forms, limit: u32, power_bits: u32) -> Self {
        let coarse = |step: i32| i64::from(step) >> (FACTOR.frac_bits() - SEARCH_BITS);
        Self {
            forms,
            step: [record.factor[0], record.factor[2]].map(coarse),
            limit: i64::from(limit) << 1 >> (power_bits - 2 * COMPARE_BITS),
        }
    }

    /// The pixels or rows at which a form of this start value and step may be within -root and root.
    fn within(start: i64, step: i64, root: i64) -> u16 {
        let start = start >> (EXACT_BITS - SEARCH_BITS);
        let mut mask = 0;
        for i in 0..TILE {
            let at = (start + step * i64::from(i)) >> (SEARCH_BITS - COMPARE_BITS);
            let is_near = -(root + 2) <= at && at <= root;
            mask |= u16::from(is_near) << i;
        }
        mask
    }

    /// The rows that may count: a mask, the first row lowest.
    #[must_use]
    pub fn rows(&self) -> u16 {
        if self.forms.is_far() {
            return 0;
        }
        Self::within(self.forms.start()[1], self.step[1], root(self.limit))
    }

    /// The pixels of a row that may count.
    #[must_use]
    pub fn pixels(&self, row: u32) -> u16 {
        let q = self.forms.at(0, row)[1];
        if self.forms.is_far() || q.unsigned_abs() >= BEYOND.unsigned_abs() {
            return 0;
        }
        let q = i64::from(q.unsigned_abs() >> (16 - COMPARE_BITS));
        let left = self.limit - q * q;
        if left < 0 {
            return 0;
        }
        Self::within(self.forms.row(row), self.step[0], root(left))
    }

    /// The rows that [`Spans::rows`] names, with their pixels.
    pub fn all(&self) -> impl Iterator<Item = Span> {
        let rows = self.rows();
        (0..TILE)
            .filter(move |row| rows >> row & 1 == 1)
            .map(|row| Span {
                row,
                mask: self.pixels(row),
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// The power of a pixel, with 13 fraction bits.
    fn power(forms: &Forms, x: u32, y: u32) -> i128 {
        let [p, q] = forms.at(x, y).map(i128::from);
        (p * p + q * q + (1 << 19)) >> 20
    }

    fn record(mean: [i32; 2], factor: [i32; 3]) -> SplatRecord {
        SplatRecord {
            mean,
            factor,
            opacity: 0,
            colour: [0; 3],
            rank: 0,
        }
    }

    /// No pixel that counts lies outside; returns how many lie inside, and how many count.
    fn check(record: &SplatRecord, corner: [i64; 2], limit: u32) -> [u32; 2] {
        let forms = Forms::new(record, corner);
        let spans = Spans::new(record, &forms, limit, 13);
        let (mut inside, mut counted) = (0, 0);
        let rows = spans.rows();
        for y in 0..TILE {
            let mask = if rows >> y & 1 == 1 {
                spans.pixels(y)
            } else {
                0
            };
            inside += mask.count_ones();
            for x in 0..TILE {
                let counts = power(&forms, x, y) <= limit.into();
                counted += u32::from(counts);
                assert!(
                    !counts || mask >> x & 1 == 1,
                    "{record:?} at {corner:?}: ({x}, {y})"
                );
            }
        }
        [inside, counted]
    }

    proptest! {
        /// Any record: nothing that counts is outside.
        #[test]
        fn nothing_that_counts_is_outside(
            mean in any::<[i32; 2]>(), near in 0u32..20, factor in any::<[i32; 3]>(),
            thin in 0u32..31, tile in any::<[u8; 2]>(), limit in 0u32..1 << 16
        ) {
            let corner = tile.map(|t| i64::from(t) << 16);
            let mean = [0, 1].map(|i| (corner[i] as i32).wrapping_add(mean[i] >> near));
            let factor = [factor[0] >> (thin / 2), factor[1] >> thin, factor[2] >> (thin / 2)];
            check(&record(mean, factor), corner, limit);
        }
    }

    /// Round Gaussians of 0.6 to 60 pixels: what is inside and does not count is less than a tenth.
    #[test]
    fn little_else_is_inside() {
        let mut all = [0, 0];
        for sixth in 1..100 {
            let l = (f64::from(1 << 30) * 1.8 / f64::from(sixth)) as i32;
            for at in 0..64i32 {
                let mean = [(at % 8) * 9000, (at / 8) * 9000];
                let found = check(&record(mean, [l, 0, l]), [0, 0], 40_000);
                all = [all[0] + found[0], all[1] + found[1]];
            }
        }
        let [inside, counted] = all.map(f64::from);
        assert!(counted > 1e5 && inside < 1.1 * counted, "{all:?}");
    }
}
