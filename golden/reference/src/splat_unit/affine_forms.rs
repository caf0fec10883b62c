//! Two affine forms of the pixel position.
//!
//! `p = L11 dx + L21 dy` and `q = L22 dy` at the offset (dx, dy) of a pixel from the mean. The sum
//! is exact (S1.30 times S19.12) and rounded once, half to even, to S15.16, saturating.
//!
//! On the MAC array a record becomes three stationary weights and two biases for a tile; pixels
//! enter as 16-bit offsets from the tile's corner. The splat unit adds a step a pixel and a row to
//! start values.

use potamoi_formats::record::{FACTOR, MEAN, SplatRecord};

/// Fraction bits of an exact sum.
const EXACT_BITS: u32 = FACTOR.frac_bits() + MEAN.frac_bits();
/// Bits that rounding to S15.16 removes.
const DROPPED: u32 = EXACT_BITS - 16;
/// Limit of the biases: 2^18 pixels, far beyond the 2^15 at which the result saturates whatever a
/// tile adds (16 x 2 x 2 at most). So 64 bits suffice and no result changes.
const BIAS_LIMIT: i128 = 1 << (EXACT_BITS + 18);

/// Start values from which on nothing in the tile counts: 128 for p and 64 for q.
const FAR: [i64; 2] = [128 << EXACT_BITS, 64 << EXACT_BITS];

/// The forms of one record in one tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Forms {
    factor: [i64; 3],
    bias: [i64; 2],
}

impl Forms {
    /// The forms of `record` in a tile. `corner` is the centre of the tile's first pixel, in codes
    /// of [`MEAN`].
    #[must_use]
    pub fn new(record: &SplatRecord, corner: [i64; 2]) -> Self {
        let [l11, l21, l22] = record.factor.map(i128::from);
        let dx = i128::from(corner[0]) - i128::from(record.mean[0]);
        let dy = i128::from(corner[1]) - i128::from(record.mean[1]);
        let held = |v: i128| v.clamp(-BIAS_LIMIT, BIAS_LIMIT) as i64;
        Self {
            factor: record.factor.map(i64::from),
            bias: [held(l11 * dx + l21 * dy), held(l22 * dy)],
        }
    }

    /// `p` and `q` at the tile's first pixel, exact: 42 fraction bits, held within 2^18.
    #[must_use]
    pub const fn start(&self) -> [i64; 2] {
        self.bias
    }

    /// `p` at the first pixel of a row, exact.
    #[must_use]
    pub fn row(&self, y: u32) -> i64 {
        self.bias[0] + self.factor[1] * (i64::from(y) << MEAN.frac_bits())
    }

    /// Whether no pixel of the tile can have both forms within 4: factors are below 2, so that a form
    /// changes by less than 30 over the columns, and by less than 30 over the rows.
    #[must_use]
    pub const fn is_far(&self) -> bool {
        let [p, q] = self.bias;
        p < -FAR[0] || p >= FAR[0] || q < -FAR[1] || q >= FAR[1]
    }

    /// `p` and `q` at pixel (`x`, `y`) of the tile, S15.16 codes.
    #[must_use]
    pub fn at(&self, x: u32, y: u32) -> [i32; 2] {
        let [l11, l21, l22] = self.factor;
        let x = i64::from(x) << MEAN.frac_bits();
        let y = i64::from(y) << MEAN.frac_bits();
        [
            round(self.bias[0] + l11 * x + l21 * y),
            round(self.bias[1] + l22 * y),
        ]
    }
}

/// Rounds away [`DROPPED`] bits, half to even, saturating.
fn round(exact: i64) -> i32 {
    let floor = exact >> DROPPED;
    let rest = exact & ((1 << DROPPED) - 1);
    let half = 1 << (DROPPED - 1);
    let up = rest > half || (rest == half && floor & 1 == 1);
    (floor + i64::from(up)).clamp(i64::from(i32::MIN), i64::from(i32::MAX)) as i32
}

#[cfg(test)]
mod tests {
    use super::*;
    use potamoi_formats::fixed::{Format, Rounding, round_shift};
    use proptest::prelude::*;

    fn oracle(r: &SplatRecord, corner: [i64; 2], x: u32, y: u32) -> [i32; 2] {
        let at = |v: u32, c: i64, m: i32| i128::from(v) * 4096 + i128::from(c) - i128::from(m);
        let (dx, dy) = (at(x, corner[0], r.mean[0]), at(y, corner[1], r.mean[1]));
        let [l11, l21, l22] = r.factor.map(i128::from);
        [l11 * dx + l21 * dy, l22 * dy].map(|exact| {
            let rounded = round_shift(exact, 26, Rounding::HalfEven);
            Format::signed(15, 16).saturate(rounded).0 as i32
        })
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

    #[test]
    fn extremes_and_ties_are_exact() {
        let ends = [i32::MIN, i32::MIN + 1, -1, 0, 1, i32::MAX];
        for mx in ends {
            for my in ends {
                for a in ends {
                    for b in ends {
                        let r = record([mx, my], [a, b, b]);
                        for corner in [[0, 0], [1 << 27, 2048], [65520 << 12, 65520 << 12]] {
                            let f = Forms::new(&r, corner);
                            for (x, y) in [(0, 0), (15, 15), (3, 0), (0, 12)] {
                                assert_eq!(f.at(x, y), oracle(&r, corner, x, y));
                            }
                        }
                    }
                }
            }
        }
        // 2^25 is half of the last bit: down to 0, and from 1.5 up to 2.
        assert_eq!(round(1 << 25), 0);
        assert_eq!(round(3 << 25), 2);
        assert_eq!(round(-(1 << 25)), 0);
    }

    proptest! {
        #[test]
        fn forms_are_the_exact_sum_rounded_once(
            mean in any::<[i32; 2]>(), near in any::<bool>(), factor in any::<[i32; 3]>(),
            tile in any::<[u8; 2]>(), x in 0u32..16, y in 0u32..16
        ) {
            // Means near the tile, where nothing saturates, as well as anywhere.
            let mean = if near { mean.map(|m| m >> 10) } else { mean };
            let r = record(mean, factor);
            let corner = tile.map(|t| i64::from(t) << 16);
            prop_assert_eq!(Forms::new(&r, corner).at(x, y), oracle(&r, corner, x, y));
        }
    }
}
