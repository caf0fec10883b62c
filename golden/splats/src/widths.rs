//! Widths of the operands that compositing sends to the vector unit.

use potamoi_formats::fixed::{Rounding, round_shift};
use potamoi_formats::units::{OpCode, VectorOp};

/// Bits of the vector unit's operands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Widths {
    /// Fraction bits of the argument, which has at least three integer bits: `exp(-8)` is skipped.
    pub power: u32,
    /// Fraction bits of the result.
    pub exponential: u32,
    /// Signed bits of p and q.
    pub form: u32,
}

/// Signed bits that transmittance (U1.20) and opacity (U0.16) need in a product.
const TRANSMITTANCE_BITS: u32 = 22;
/// Signed bits of an alpha's complement, up to 2^16.
const COMPLEMENT_BITS: u32 = 18;

impl Widths {
    /// The paper's widths.
    pub const PAPER: Self = Self {
        power: 13,
        exponential: 16,
        form: 32,
    };

    /// Fewest signed bits of p and q with which the picture is that of 32 bits: the ends of their
    /// range give `largest`, the largest argument of the exponential, or more.
    #[must_use]
    pub fn least_form(power: u32, largest: i128) -> u32 {
        let shift = 33u32.saturating_sub(power);
        let decides = |bits: &u32| {
            let end = (1i128 << (bits - 1)) - 1;
            round_shift(end * end, shift, Rounding::HalfUp) >= largest
        };
        (2..32).find(decides).unwrap_or(32)
    }

    /// Fewest signed bits of the two factors of a product, with so many fraction bits of an
    /// exponential.
    #[must_use]
    pub fn least_factors(exponential: u32) -> [u32; 2] {
        [TRANSMITTANCE_BITS, COMPLEMENT_BITS.max(exponential + 1)]
    }

    /// A form within its bits.
    pub(crate) const fn held(self, form: i32) -> i32 {
        let most = i32::MAX >> (32 - self.form);
        if form > most {
            most
        } else if form < -most - 1 {
            -most - 1
        } else {
            form
        }
    }

    /// The operation for half the sum of two squares, from 32 fraction bits to those of the
    /// argument.
    pub(crate) const fn to_power(self) -> VectorOp {
        op(OpCode::SquareSum, 33u32.saturating_sub(self.power) as u8)
    }

    pub(crate) const fn to_alpha(self) -> VectorOp {
        op(OpCode::Multiply, self.exponential as u8)
    }
}

/// An operation that rounds half up.
pub(crate) const fn op(code: OpCode, shift: u8) -> VectorOp {
    VectorOp {
        code,
        shift,
        rounding: Rounding::HalfUp,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's: 18 bits of magnitude, of which 16 are a fraction, so that 4 is beyond them.
    #[test]
    fn a_form_that_is_held_decides_by_itself() {
        let paper = Widths::least_form(13, (1 << 16) - 1);
        assert_eq!(paper, 19);
        assert_eq!(Widths::least_factors(16), [22, 18]);
        let narrow = Widths {
            form: paper,
            ..Widths::PAPER
        };
        let exp = |form: i32| round_shift(i128::from(form).pow(2), 20, Rounding::HalfUp);
        for far in [1 << 18, i32::MAX, i32::MIN, -(1 << 18) - 1, 300_000] {
            assert!(exp(narrow.held(far)) >= (1 << 16) - 1, "{far}");
        }
        for near in [0, (1 << 18) - 1, -(1 << 18)] {
            assert_eq!(narrow.held(near), near);
        }
        let short = Widths { form: 18, ..narrow };
        assert!(exp(short.held(i32::MAX)) < (1 << 16) - 1);
        assert_eq!(Widths::PAPER.held(i32::MIN), i32::MIN);
        // A step of the argument as fine as the square: more bits.
        assert!(Widths::least_form(20, (1 << 23) - 1) > paper);
    }
}
