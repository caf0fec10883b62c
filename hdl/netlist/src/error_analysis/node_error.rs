//! Error of a value: an interval, and dropped bits of other nodes.

use std::collections::BTreeMap;

use num_bigint::BigInt;
use num_traits::{One, Zero};
use potamoi_formats::fixed::Rounding;

use crate::range::Interval;

/// Fraction bits of errors, which are counted in the node's ulp.
const FRACTION: u32 = 64;

/// The low bits of a node: its number, and their count.
pub(super) type Cut = (usize, u32);

/// The value minus its exact value, in its ulp.
///
/// Dropped bits and values made of them are kept symbolically, so that a dropped bit that also
/// rounds gives an error of 0.5 ulp, not 1.5.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct NodeError {
    /// Independent error, with [`FRACTION`] fraction bits.
    rest: Interval,
    /// Factors of the dropped bits' values, with [`FRACTION`] fraction bits.
    cuts: BTreeMap<Cut, BigInt>,
}

impl NodeError {
    pub(super) fn none() -> Self {
        Self::rest(Interval::new(0, 0))
    }

    fn rest(rest: Interval) -> Self {
        let cuts = BTreeMap::new();
        Self { rest, cuts }
    }

    pub(super) fn is_none(&self) -> bool {
        *self == Self::none()
    }

    /// The error of a dropped bit.
    pub(super) fn bit() -> Self {
        Self::rest(Interval::new(0, BigInt::one() << FRACTION))
    }

    /// The error of a node's low bits used alone: all of them.
    pub(super) fn of_cut(cut: Cut) -> Self {
        let mut off = Self::none();
        off.cuts.insert(cut, BigInt::one() << FRACTION);
        off
    }

    /// The error of a node's known low bits.
    pub(super) fn of_known(value: &Interval, bits: u32) -> Self {
        let low = &value.low & ((BigInt::one() << bits) - 1u8);
        Self::rest(Interval::point(&(low << FRACTION)))
    }

    /// Smallest and largest error, with [`FRACTION`] fraction bits.
    fn ends(&self) -> Interval {
        let mut sum = self.rest.clone();
        for ((_, bits), times) in &self.cuts {
            let most = (BigInt::one() << bits) - 1u8;
            sum = sum.add(&Interval::new(0, most).mul(&Interval::point(times)));
        }
        sum
    }

    /// The same error without correlations.
    pub(super) fn alone(&self) -> Self {
        Self::rest(self.ends())
    }

    /// Smallest and largest error in ulp, rounded outwards.
    pub(super) fn bounds(&self) -> [f64; 2] {
        let ends = self.ends();
        let scale = 2f64.powi(-(FRACTION as i32));
        let number = |v: &BigInt| num_traits::ToPrimitive::to_f64(v).unwrap_or(f64::INFINITY);
        [
            (number(&ends.low) * scale).next_down(),
            (number(&ends.high) * scale).next_up(),
        ]
    }

    pub(super) fn add(&self, other: &Self) -> Self {
        let mut sum = self.clone();
        sum.rest = sum.rest.add(&other.rest);
        for (cut, times) in &other.cuts {
            let entry = sum.cuts.entry(*cut).or_default();
            *entry += times;
            if entry.is_zero() {
                sum.cuts.remove(cut);
            }
        }
        sum
    }

    pub(super) fn neg(&self) -> Self {
        Self {
            rest: self.rest.neg(),
            cuts: self.cuts.iter().map(|(c, t)| (*c, -t)).collect(),
        }
    }

    pub(super) fn shl(&self, bits: u32) -> Self {
        Self {
            rest: self.rest.shl(bits, bits),
            cuts: self.cuts.iter().map(|(c, t)| (*c, t << bits)).collect(),
        }
    }

    /// Divides by a power of two, and subtracts the dropped bits.
    pub(super) fn cut(&self, cut: Cut) -> Self {
        let mut off = self.divided(cut.1);
        if cut.1 <= FRACTION {
            let times = off.cuts.entry(cut).or_default();
            *times -= BigInt::one() << (FRACTION - cut.1);
            if times.is_zero() {
                off.cuts.remove(&cut);
            }
            off
        } else {
            off.add(&Self::rest(Interval::new(-(BigInt::one() << FRACTION), 0)))
        }
    }

    /// Divides by a power of two, where the value is rounded down.
    pub(super) fn shr(&self, bits: u32, value: &Interval) -> Self {
        let mask = (BigInt::one() << bits) - 1u8;
        let dropped = if value.is_point() {
            Interval::point(&(&value.low & &mask))
        } else {
            Interval::new(0, mask)
        };
        let dropped = Self::rest(dropped.shl(FRACTION, FRACTION)).divided(bits);
        self.divided(bits).add(&dropped.neg())
    }

    /// Divides by a power of two, where the value is rounded.
    pub(super) fn round(&self, bits: u32, rounding: Rounding, value: &Interval) -> Self {
        if rounding == Rounding::Floor {
            return self.shr(bits, value);
        }
        let one = BigInt::one() << bits;
        let half = &one >> 1u8;
        let off = if value.is_point() {
            let rest = &value.low & (&one - 1u8);
            let tie_goes_up = rounding == Rounding::HalfUp || value.low.bit(u64::from(bits));
            match rest > half || (rest == half && tie_goes_up) {
                true => Interval::point(&(one - rest)),
                false => Interval::point(&-rest),
            }
        } else {
            // Half up, less than a half is dropped.
            let dropped = match rounding {
                Rounding::HalfUp => &half - 1u8,
                _ => half.clone(),
            };
            Interval::new(-dropped, half)
        };
        let off = Self::rest(off.shl(FRACTION, FRACTION)).divided(bits);
        self.divided(bits).add(&off)
    }

    fn divided(&self, bits: u32) -> Self {
        let exact = |t: &BigInt| (t >> bits) << bits == *t;
        if !self.cuts.values().all(exact) {
            return self.alone().divided(bits);
        }
        let down = |v: &BigInt| v >> bits;
        Self {
            rest: Interval::new(down(&self.rest.low), -down(&-&self.rest.high)),
            cuts: self.cuts.iter().map(|(c, t)| (*c, t >> bits)).collect(),
        }
    }

    /// Error of a product: `A b' + B a' - a' b'`.
    pub(super) fn product(&self, other: &Self, value: &Interval, of_other: &Interval) -> Self {
        let (a, b) = (self.ends(), other.ends());
        let both = a.mul(&b);
        let both = Interval::new(&both.low >> FRACTION, -(-&both.high >> FRACTION));
        Self::rest(value.mul(&b).add(&of_other.mul(&a)).add(&both.neg()))
    }

    pub(super) fn join(&self, other: &Self) -> Self {
        if self == other {
            return self.clone();
        }
        Self::rest(self.ends().join(&other.ends()))
    }
}

#[cfg(test)]
mod tests {
    use potamoi_formats::fixed::round_shift;

    use super::*;

    #[test]
    fn a_rounding_is_off_by_what_it_is_over_all_values() {
        for rounding in [Rounding::Floor, Rounding::HalfUp, Rounding::HalfEven] {
            for bits in 1..=4u32 {
                let off = |value: &Interval| NodeError::none().round(bits, rounding, value).ends();
                let scaled = |v: i128| BigInt::from(v) << (FRACTION - bits);
                let exact = |v: i128| (round_shift(v, bits, rounding) << bits) - v;
                let all = -64..64i128;
                for v in all.clone() {
                    let found = off(&Interval::point(&BigInt::from(v)));
                    assert_eq!(found, Interval::point(&scaled(exact(v))), "{v} {bits}");
                }
                let ends = [all.clone().map(exact).min(), all.map(exact).max()];
                let [least, most] = ends.map(|end| scaled(end.unwrap_or_default()));
                let found = off(&Interval::new(-64, 63));
                assert_eq!(found, Interval::new(least, most), "{rounding:?} {bits}");
            }
        }
    }
}
