//! Widths of the exponential in straight pieces.

use super::{Engine, ExpBase, ExpConfig};

/// Widths of a table of straight pieces, beside those in [`Engine`].
///
/// `y = 2^(1-f)` on piece i: a start of the accumulator's fraction bits less a
/// slope times what of `f` lies within the piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PieceWidths {
    /// Bits of `f` that name the piece.
    pub index_bits: u32,
    /// Fraction bits of a slope, which is 0.69 to 1.39.
    pub slope_bits: u32,
    /// Fraction bits of `log2 e`; none where the operand is a power of two.
    pub scale_bits: Option<u32>,
}

impl PieceWidths {
    /// Bits of the table.
    #[must_use]
    pub const fn table_bits(&self, engine: &Engine) -> u32 {
        (engine.accumulator_bits + self.slope_bits + 1) << self.index_bits
    }

    /// Partial-product bits of the slope's multiplier.
    #[must_use]
    pub const fn slope_product_bits(&self, engine: &Engine) -> u32 {
        (self.slope_bits + 1) * (engine.constant_bits - self.index_bits)
    }

    /// Partial-product bits of the multiplication of an operand of so many bits
    /// by `log2 e`.
    #[must_use]
    pub fn scale_product_bits(&self, operand: u32) -> u32 {
        self.scale_bits.map_or(0, |bits| operand * (bits + 1))
    }
}

impl ExpConfig {
    /// Widths of the table, of the piecewise form. A slope is rounded to what
    /// moves the end of a piece by half a unit of its start; `log2 e` to two
    /// bits less than the power.
    #[must_use]
    pub fn piece_widths(&self) -> PieceWidths {
        let engine = self.piecewise_engine();
        let index_bits = self.pieces.max(2).ilog2();
        PieceWidths {
            index_bits,
            slope_bits: engine
                .accumulator_bits
                .saturating_sub(index_bits + 3)
                .max(1),
            scale_bits: match self.base {
                ExpBase::E => Some(engine.constant_bits.saturating_sub(2)),
                ExpBase::Two => None,
            },
        }
    }

    /// Four guard bits for the pieces, three for the power of two: the largest
    /// errors over all inputs are in `docs/reference/vector-unit.md`.
    pub(super) fn piecewise_engine(&self) -> Engine {
        let least = self.input.frac_bits().max(self.pieces.max(2).ilog2() + 4);
        Engine {
            accumulator_bits: self.accumulator_bits.unwrap_or(self.output_bits + 4),
            constant_bits: self
                .constant_bits
                .unwrap_or(self.output_bits + 3)
                .max(least),
            offset: 0,
            centred: false,
            digits: 0,
            bias: 0,
            steps: 0,
        }
    }
}
