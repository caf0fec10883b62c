//! `2^-v` from a piecewise linear table, `v = u log2 e`: one result a clock.

use super::engine::Engine;
use super::form::{Form, Offers};
use super::knobs::{ExpBase, ExpConfig};
use crate::config::breaches::RuleBreaches;
use crate::timing::{Pipeline, PowerStage};

pub(super) struct Piecewise;

impl Form for Piecewise {
    fn offers(&self) -> Offers {
        Offers {
            base_two: true,
            one_minus: true,
            ..Offers::default()
        }
    }

    /// Four guard bits for the pieces, three for the exponent; the largest errors over all inputs
    /// are in `docs/reference/vector-unit.md`.
    fn engine(&self, exp: &ExpConfig) -> Engine {
        let least = exp.input.frac_bits().max(exp.pieces.max(2).ilog2() + 4);
        Engine {
            accumulator_bits: exp.accumulator_bits.unwrap_or(exp.output_bits + 4),
            constant_bits: exp.constant_bits.unwrap_or(exp.output_bits + 3).max(least),
            offset: 0,
            centred: false,
            digits: 0,
            bias: 0,
            steps: 0,
        }
    }

    fn stages(&self, exp: &ExpConfig) -> Pipeline<PowerStage> {
        Pipeline::power_of_two(exp.base == ExpBase::Two)
    }

    fn least_constant_bits(&self, exp: &ExpConfig) -> (u32, &'static str) {
        (
            exp.input.frac_bits().max(exp.piece_widths().index_bits + 4),
            "at least the input's fraction bits, and 4 beyond those that name a piece",
        )
    }

    fn rules(&self, exp: &ExpConfig, out: &mut RuleBreaches) {
        let count = exp.pieces;
        out.require(
            count.is_power_of_two() && (16..=1024).contains(&count),
            "exp-pieces",
            "vu.exp.pieces",
            count,
            "a power of two, 16 to 1024: the first bits of the power name the piece",
        );
        out.require(
            exp.pipelined,
            "exp-pieces-pipelined",
            "vu.exp.pipelined",
            exp.pipelined,
            "true: the pieces give one result a clock",
        );
        let most = 2 * count.max(1).ilog2() + 4;
        out.require(
            exp.output_bits <= most,
            "exp-pieces-output-bits",
            "vu.exp.output_bits",
            exp.output_bits,
            format_args!(
                "at most {most} with {count} pieces, whose error is then below half a unit, so that 1 - exp(0) is 0"
            ),
        );
        for (unset, field, value) in [
            (!exp.tail, "vu.exp.tail", exp.tail.to_string()),
            (
                exp.offset.is_none(),
                "vu.exp.offset",
                exp.offset.unwrap_or_default().to_string(),
            ),
            (
                !exp.early_out,
                "vu.exp.early_out",
                exp.early_out.to_string(),
            ),
        ] {
            out.require(
                unset,
                "exp-pieces-knobs",
                field,
                value,
                "left out: the pieces take no iterations",
            );
        }
    }

    fn plain(&self, exp: &mut ExpConfig) {
        exp.pipelined = true;
    }

    fn forget(&self, exp: &mut ExpConfig, plain: &ExpConfig) {
        exp.iterations = plain.iterations;
        exp.iterations_per_clock = plain.iterations_per_clock;
        exp.tail = plain.tail;
        exp.early_out = plain.early_out;
    }
}

/// Widths of a piecewise linear table, beside those in [`Engine`].
///
/// `y = 2^(1-f)` on piece i: a start value minus a slope times the offset of `f` within the piece.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PieceWidths {
    /// Bits of `f` that select the piece.
    pub index_bits: u32,
    /// Fraction bits of a slope, which is from 0.69 to 1.39.
    pub slope_bits: u32,
    /// Fraction bits of `log2 e`; `None` where the operand is already in base two.
    pub scale_bits: Option<u32>,
}

impl PieceWidths {
    /// Size of the table in bits.
    #[must_use]
    pub const fn table_bits(&self, engine: &Engine) -> u32 {
        (engine.accumulator_bits + self.slope_bits + 1) << self.index_bits
    }

    /// Partial-product bits of the slope's multiplier.
    #[must_use]
    pub const fn slope_product_bits(&self, engine: &Engine) -> u32 {
        (self.slope_bits + 1) * (engine.constant_bits - self.index_bits)
    }

    /// Partial-product bits of the multiplier of an `operand`-bit value by `log2 e`.
    #[must_use]
    pub fn scale_product_bits(&self, operand: u32) -> u32 {
        self.scale_bits.map_or(0, |bits| operand * (bits + 1))
    }
}

impl ExpConfig {
    /// Widths of the table in the piecewise form. A slope is rounded so that the end of a piece
    /// moves by at most half a unit of its start; `log2 e` has two bits fewer than the exponent.
    #[must_use]
    pub fn piece_widths(&self) -> PieceWidths {
        let engine = Piecewise.engine(self);
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
}
