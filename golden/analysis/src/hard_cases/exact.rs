//! Numbers of 256 bits for exact references.

use std::ops::{Add, Div, Mul, Sub};

use astro_float::{BigFloat, Consts, RoundingMode};

use potamoi_reference::exact_exponential::parts;

const BITS: usize = 256;
const NEAREST: RoundingMode = RoundingMode::ToEven;

#[derive(Debug, Clone)]
pub(super) struct Exact(BigFloat);

/// The number, whose 53 bits are all kept.
pub(super) fn exact(value: f64) -> Exact {
    Exact(BigFloat::from_f64(value, BITS))
}

/// A number computed with the library's constants; none where there is no memory for them.
fn with_constants(compute: impl FnOnce(&mut Consts) -> BigFloat) -> BigFloat {
    Consts::new().map_or(astro_float::NAN, |mut consts| compute(&mut consts))
}

impl Exact {
    pub(super) fn sqrt(&self) -> Self {
        Self(self.0.sqrt(BITS, NEAREST))
    }

    pub(super) fn exp(&self) -> Self {
        Self(with_constants(|c| self.0.exp(BITS, NEAREST, c)))
    }

    pub(super) fn atan(&self) -> Self {
        Self(with_constants(|c| self.0.atan(BITS, NEAREST, c)))
    }

    pub(super) fn powi(&self, n: usize) -> Self {
        Self(self.0.powi(n, BITS, NEAREST))
    }

    pub(super) fn pi() -> Self {
        Self(with_constants(|c| c.pi(BITS, NEAREST)))
    }

    pub(super) fn is_zero(&self) -> bool {
        self.0.is_zero()
    }

    /// Truncated to 127 bits, then rounded to a double.
    pub(super) fn to_f64(&self) -> f64 {
        if self.0.is_zero() {
            return 0.0;
        }
        // Of no number no error is known: it counts as infinite.
        let Some((mantissa, exponent)) = parts(&self.0.abs()) else {
            return f64::NAN;
        };
        let sign = if self.0.is_negative() { -1.0 } else { 1.0 };
        // In two steps: the power alone may lie outside a double's range.
        let half = exponent / 2;
        sign * (mantissa as f64 * 2f64.powi(-126)) * 2f64.powi(half) * 2f64.powi(exponent - half)
    }

    /// Error of a double.
    pub(super) fn error(&self, found: f64) -> f64 {
        if found.is_finite() {
            (exact(found) - self.clone()).to_f64()
        } else {
            f64::INFINITY
        }
    }

    /// Relative error of a double.
    pub(super) fn relative(&self, found: f64) -> f64 {
        self.error(found) / self.to_f64()
    }
}

macro_rules! operator {
    ($trait:ident, $name:ident) => {
        impl $trait for Exact {
            type Output = Self;

            fn $name(self, other: Self) -> Self {
                Self(self.0.$name(&other.0, BITS, NEAREST))
            }
        }
    };
}
operator!(Add, add);
operator!(Sub, sub);
operator!(Mul, mul);
operator!(Div, div);

#[test]
fn numbers_are_those_of_the_library_and_go_both_ways() {
    for value in [1.0, -0.1, 3e-300, 1e300, 0.0, -3e-308] {
        assert_eq!(exact(value).to_f64(), value);
    }
    let third = exact(1.0) / exact(3.0);
    assert_eq!(third.to_f64(), 1.0 / 3.0);
    // A third is 2^-54 / 3 above the double below it.
    assert!((third.error(1.0 / 3.0) * 2f64.powi(54) * 3.0 + 1.0).abs() < 1e-9);
    assert!((Exact::pi().to_f64() - std::f64::consts::PI).abs() < 1e-300);
    assert!(
        (exact(1.0).atan() * exact(4.0) - Exact::pi())
            .to_f64()
            .abs()
            < 1e-70
    );
    assert!((exact(2.0).sqrt().powi(2) - exact(2.0)).to_f64().abs() < 1e-70);
    assert!(exact(f64::NAN).error(f64::NAN).is_infinite());
}
