//! How far a value is off, as an interval and the bits that were cut from others.

use std::collections::BTreeMap;

use num_bigint::BigInt;
use num_traits::{One, Zero};
use potamoi_formats::fixed::Rounding;

use crate::range::Interval;

/// Fraction bits of what is counted here, in last places of the node.
const FRACTION: u32 = 64;

/// The low bits of a node: its number, and how many of them.
pub(super) type Cut = (usize, u32);

/// The value less what it would be had no bit been dropped, in its last places.
///
/// What a cut took away and what is made of the bits that were cut stay together,
/// so that a bit that is dropped and then rounds is off by half, not by one and a
/// half.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Off {
    /// With [`FRACTION`] fraction bits.
    rest: Interval,
    /// Times the cut bits' value, with [`FRACTION`] fraction bits.
    cuts: BTreeMap<Cut, BigInt>,
}

impl Off {
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

    /// A bit that is all off.
    pub(super) fn bit() -> Self {
        Self::rest(Interval::new(0, BigInt::one() << FRACTION))
    }

    /// The low bits of a node by themselves: all of them are off.
    pub(super) fn of_cut(cut: Cut) -> Self {
        let mut off = Self::none();
        off.cuts.insert(cut, BigInt::one() << FRACTION);
        off
    }

    /// The same of a node of one value.
    pub(super) fn of_known(value: &Interval, bits: u32) -> Self {
        let low = &value.low & ((BigInt::one() << bits) - 1u8);
        Self::rest(Interval::point(&(low << FRACTION)))
    }

    /// The least and the most, with [`FRACTION`] fraction bits.
    fn ends(&self) -> Interval {
        let mut sum = self.rest.clone();
        for ((_, bits), times) in &self.cuts {
            let most = (BigInt::one() << bits) - 1u8;
            sum = sum.add(&Interval::new(0, most).mul(&Interval::point(times)));
        }
        sum
    }

    /// The same without what it has to do with others.
    pub(super) fn alone(&self) -> Self {
        Self::rest(self.ends())
    }

    /// The least and the most, in last places, rounded outwards.
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

    /// Divided by a power of two, and less what is cut of the node.
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

    /// Divided by a power of two, the value then rounded down.
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

    /// Divided by a power of two, the value then rounded.
    pub(super) fn round(&self, bits: u32, rounding: Rounding, value: &Interval) -> Self {
        if rounding == Rounding::Floor {
            return self.shr(bits, value);
        }
        let half = BigInt::one() << (FRACTION - 1);
        let off = Self::rest(Interval::new(-&half, half));
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

    /// Of a product of values that are off: `A b' + B a' - a' b'`.
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
