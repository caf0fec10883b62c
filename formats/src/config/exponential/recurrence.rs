//! Common parts of the forms that compare, subtract, shift and add.

use super::engine::Engine;
use super::knobs::ExpConfig;
use crate::timing::{Pipeline, PowerStage};

/// Parameters of a recurrence.
pub(super) struct Recurrence {
    /// Exponent digits, and initial `R_remain` in units of `ln 2`.
    pub(super) digits: u32,
    pub(super) bias: u32,
    /// Accumulator bits, constant bits and offset, where known from the search.
    pub(super) known: Option<(u32, u32, i32)>,
    /// Whether the truncation error may be centred.
    pub(super) centres: bool,
}

impl Recurrence {
    /// Widths of an engine that resolves `n` bits of the power.
    pub(super) fn engine(&self, exp: &ExpConfig, n: u32) -> Engine {
        let f = exp.output_bits;
        // Past the table: guard bits that keep every term of the error budget
        // but the truncation below a quarter unit.
        let guard = (2 * (n + 4)).ilog2() + 1;
        let accumulator_bits = exp
            .accumulator_bits
            .unwrap_or(self.known.map_or(f + guard, |k| k.0));
        let constant_bits = exp
            .constant_bits
            .unwrap_or(self.known.map_or((f + guard).max(n + 1), |k| k.1))
            .max(exp.input.frac_bits());
        Engine {
            accumulator_bits,
            constant_bits,
            offset: exp.offset.unwrap_or(self.known.map_or(0, |k| k.2)),
            centred: self.centres && !exp.tail && constant_bits > n,
            digits: self.digits,
            bias: self.bias,
            steps: self.digits + exp.iterations,
        }
    }
}

/// Clocks of the steps, several a clock, and the tail.
pub(super) fn stages(exp: &ExpConfig) -> Pipeline<PowerStage> {
    let a_clock = exp.iterations_per_clock.max(1);
    Pipeline::recurrence(exp.engine().steps.div_ceil(a_clock), exp.tail)
}

/// Smallest widths found by exhaustive search over the 65,536 inputs of U3.13:
/// accumulator bits, constant bits, offset. The search and what it aims at for
/// each n are `potamoi_reference::widths`.
pub(super) fn known_widths(n: u32, f: u32, tail: bool) -> Option<(u32, u32, i32)> {
    match (f, n, tail) {
        // 126.9, 8.2 and 0.973 ulp: the truncation, and hardly more.
        (16, 8, false) => Some((16, 13, 0)),
        (16, 12, false) => Some((16, 13, 3)),
        (16, 16, false) => Some((19, 19, -2)),
        // 0.748 ulp.
        (16, 20, false) => Some((18, 19, -1)),
        // 0.998, 0.683 (one bit of the accumulator less: 0.792) and 0.692 ulp.
        (16, 8, true) => Some((16, 19, 0)),
        (16, 9, true) => Some((18, 19, 0)),
        (16, 12, true) => Some((18, 19, 0)),
        // Correctly rounded.
        (16, 27, false) => Some((27, 29, 0)),
        (16, 14, true) => Some((27, 28, 0)),
        (16, 16, true) => Some((27, 29, 0)),
        (16, 20, true) => Some((28, 27, -1)),
        (16, 27, true) => Some((27, 28, 0)),
        // Below 1 ulp.
        (8, 8, false) => Some((10, 13, 0)),
        (8, 4, true) => Some((8, 13, 0)),
        (12, 12, false) => Some((15, 13, 2)),
        (12, 6, true) => Some((12, 15, 0)),
        (24, 24, false) => Some((27, 27, -1)),
        (24, 12, true) => Some((28, 25, 2)),
        // Correctly rounded.
        (8, 23, false) => Some((23, 24, 0)),
        (8, 11, true) => Some((20, 22, 0)),
        (12, 25, false) => Some((26, 26, 1)),
        (12, 13, true) => Some((22, 25, 0)),
        (24, 18, true) => Some((38, 37, 1)),
        _ => None,
    }
}
