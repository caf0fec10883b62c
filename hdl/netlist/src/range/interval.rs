//! Intervals of integers.

use std::fmt;

use num_bigint::{BigInt, Sign};
use num_traits::{One, Zero};
use potamoi_formats::fixed::Rounding;

use crate::node::Ty;

/// The integers `low ..= high`.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Interval {
    /// Smallest value.
    pub low: BigInt,
    /// Largest value.
    pub high: BigInt,
}

impl fmt::Display for Interval {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} to {}", Short(&self.low), Short(&self.high))
    }
}

/// A readable form of a number.
struct Short<'a>(&'a BigInt);

impl fmt::Display for Short<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.bits() <= 128 {
            return write!(f, "{}", self.0);
        }
        let sign = if self.0.sign() == Sign::Minus {
            "-"
        } else {
            ""
        };
        write!(f, "about {sign}2^{}", self.0.bits() - 1)
    }
}

impl Interval {
    /// `low ..= high`.
    #[must_use]
    pub fn new(low: impl Into<BigInt>, high: impl Into<BigInt>) -> Self {
        Self {
            low: low.into(),
            high: high.into(),
        }
    }

    pub(crate) fn zero() -> Self {
        Self::new(0, 0)
    }

    pub(crate) fn point(value: &BigInt) -> Self {
        Self::new(value.clone(), value.clone())
    }

    /// All values of a type.
    #[must_use]
    pub fn all(ty: Ty) -> Self {
        Self::new(ty.min(), ty.max())
    }

    pub(crate) fn fits(&self, ty: Ty) -> bool {
        // Of what surely fits, the ends of the type need not be made.
        let bits = self.low.bits().max(self.high.bits());
        let sign = ty.signed || self.low.sign() != Sign::Minus;
        if sign && bits < u64::from(ty.width) {
            return true;
        }
        self.within(&Self::all(ty))
    }

    pub(crate) fn within(&self, other: &Self) -> bool {
        other.low <= self.low && self.high <= other.high
    }

    /// Whether it contains exactly one value.
    #[must_use]
    pub fn is_point(&self) -> bool {
        self.low == self.high
    }

    pub(crate) fn contains(&self, value: &BigInt) -> bool {
        &self.low <= value && value <= &self.high
    }

    pub(crate) fn join(&self, other: &Self) -> Self {
        Self::new(
            (&self.low).min(&other.low).clone(),
            (&self.high).max(&other.high).clone(),
        )
    }

    /// Intersection; `None` if empty.
    pub(crate) fn meet(&self, other: &Self) -> Option<Self> {
        let low = (&self.low).max(&other.low).clone();
        let high = (&self.high).min(&other.high).clone();
        (low <= high).then(|| Self::new(low, high))
    }

    /// The narrowest type that holds it, unsigned if possible.
    pub(crate) fn ty(&self, signed: bool) -> Ty {
        if !signed && self.low.sign() != Sign::Minus {
            return Ty::u((self.high.bits() as u32).max(1));
        }
        let below = if self.low.sign() == Sign::Minus {
            (-&self.low - 1u8).bits()
        } else {
            0
        };
        let above = if self.high.sign() == Sign::Minus {
            0
        } else {
            self.high.bits()
        };
        Ty::s(below.max(above) as u32 + 1)
    }

    /// Interval of the values truncated to a type.
    pub(crate) fn wrap(&self, ty: Ty) -> Self {
        if self.fits(ty) {
            return self.clone();
        }
        let all = Self::all(ty);
        let lap = |value: &BigInt| (value - &all.low) >> ty.width;
        let (first, last) = (lap(&self.low), lap(&self.high));
        if first != last {
            return all;
        }
        let turn = first << ty.width;
        Self::new(&self.low - &turn, &self.high - turn)
    }

    /// Difference of its ends.
    pub(crate) fn span(&self) -> BigInt {
        &self.high - &self.low
    }

    pub(crate) fn neg(&self) -> Self {
        Self::new(-&self.high, -&self.low)
    }

    pub(crate) fn add(&self, other: &Self) -> Self {
        Self::new(&self.low + &other.low, &self.high + &other.high)
    }

    pub(crate) fn mul(&self, other: &Self) -> Self {
        let corners = [
            &self.low * &other.low,
            &self.low * &other.high,
            &self.high * &other.low,
            &self.high * &other.high,
        ];
        hull(corners)
    }

    pub(crate) fn shl(&self, least: u32, most: u32) -> Self {
        hull([
            &self.low << least,
            &self.low << most,
            &self.high << least,
            &self.high << most,
        ])
    }

    /// Right shift, rounded towards minus infinity.
    pub(crate) fn shr(&self, least: u32, most: u32) -> Self {
        hull([
            &self.low >> least,
            &self.low >> most,
            &self.high >> least,
            &self.high >> most,
        ])
    }

    pub(crate) fn round(&self, bits: u32, rounding: Rounding) -> Self {
        // Rounding is monotone.
        Self::new(
            rounded(&self.low, bits, rounding),
            rounded(&self.high, bits, rounding),
        )
    }

    pub(crate) fn clamp(&self, ty: Ty) -> Self {
        let (min, max) = (ty.min(), ty.max());
        Self::new(
            self.low.clone().clamp(min.clone(), max.clone()),
            self.high.clone().clamp(min, max),
        )
    }

    /// Sum of up to `times` of its values.
    pub(crate) fn up_to(&self, times: &BigInt) -> Self {
        let none = BigInt::zero();
        Self::new(
            (&self.low * times).min(none.clone()),
            (&self.high * times).max(none),
        )
    }

    /// Bitwise and of two's complement values.
    pub(crate) fn and(&self, other: &Self) -> Option<Self> {
        let positive = |i: &Self| i.low.sign() != Sign::Minus;
        match (positive(self), positive(other)) {
            (true, true) => Some(Self::new(0, (&self.high).min(&other.high).clone())),
            (true, false) => Some(Self::new(0, self.high.clone())),
            (false, true) => Some(Self::new(0, other.high.clone())),
            (false, false) => None,
        }
    }

    /// Bitwise or and exclusive or of non-negative values.
    pub(crate) fn or(&self, other: &Self) -> Option<Self> {
        if self.low.sign() == Sign::Minus || other.low.sign() == Sign::Minus {
            return None;
        }
        let bits = self.high.bits().max(other.high.bits());
        Some(Self::new(0, (BigInt::one() << bits) - 1u8))
    }
}

fn hull<const N: usize>(values: [BigInt; N]) -> Interval {
    let mut all = values.into_iter();
    let first = all.next().unwrap_or_default();
    all.fold(Interval::point(&first), |i, v| i.join(&Interval::point(&v)))
}

fn rounded(value: &BigInt, bits: u32, rounding: Rounding) -> BigInt {
    let floor = value >> bits;
    let rest = value - (&floor << bits);
    let half = BigInt::one() << (bits - 1);
    let up = match rounding {
        Rounding::Floor => false,
        Rounding::HalfUp => rest >= half,
        Rounding::HalfEven => rest > half || (rest == half && floor.bit(0)),
    };
    floor + u8::from(up)
}
