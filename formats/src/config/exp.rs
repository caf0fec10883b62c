//! The exponential engine's knobs and the widths they imply.

use serde::{Deserialize, Serialize};

use crate::fixed::Format;
use crate::timing::{AGREEMENT, Passes, Pipeline, PowerStage};
use crate::units::OpCode;

/// How exponentials are found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ExpForm {
    /// Restoring, right for negative powers: four digits of `k ln 2` first,
    /// then `ln(1 + 2^-i)`, `i = 1..n`.
    Restoring,
    /// The recurrence as the paper prints it: `i = 0..n-1` on a signed power
    /// in [-1, 1). Every constant is positive, so negative powers come out
    /// as 1. Kept to show that.
    Literal,
    /// `2^-v` from a table of straight pieces, `v = u log2 e`: one result a
    /// clock.
    Piecewise,
    /// As restoring, two bits at a time: factors `1 + d 4^-j`, `d` in 0..=3,
    /// `j = 1..iterations`, after two digits of `4^j ln 2`.
    #[serde(rename = "radix-4")]
    Radix4,
}

/// The base of what the operation `exp` is a power of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ExpBase {
    /// `exp(-u)`.
    E,
    /// `2^-u`: `log2 e` is folded into the operand by whoever makes it.
    Two,
}

/// What a result looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ExpOutput {
    /// Unsigned input `u`, result `exp(-u)` in `U0.F`, 1 saturating to the
    /// largest code.
    Alpha,
    /// Signed input `x`, result `exp(x)` as {exponent, mantissa}: bits F..0
    /// are a mantissa U1.F in [1, 2), the bits above a signed exponent.
    General,
}

/// Knobs of the exponential engine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExpConfig {
    /// How exponentials are found.
    pub form: ExpForm,
    /// What a result looks like.
    pub output: ExpOutput,
    /// What is raised to a power; base two of the piecewise form alone.
    pub base: ExpBase,
    /// Pieces of the piecewise form's table, a power of two.
    pub pieces: u32,
    /// Iterations `n` past the exponent's digits; digits `J` of radix 4.
    pub iterations: u32,
    /// A power of exponent k takes only the iterations that its bits need,
    /// `min(n, F - k + 2)`; a vector as long as the longest of its lanes.
    pub early_out: bool,
    /// Finish with one multiply by 1 + the residual.
    pub tail: bool,
    /// Iterations a clock, `r`.
    pub iterations_per_clock: u32,
    /// One result a clock: a stage for every clock's worth of iterations.
    pub pipelined: bool,
    /// Input format: unsigned for alpha, signed for general. Its fraction bits
    /// are also those of the operands of sigmoid and softplus.
    pub input: Format,
    /// Fraction bits `F` of the result.
    pub output_bits: u32,
    /// Fraction bits of the input of `1 - exp(-s)`, whose range is 0..16.
    pub one_minus_frac_bits: u32,
    /// Fraction bits of `R_accum`, or of a piece's start; the default follows
    /// n, F and tail.
    pub accumulator_bits: Option<u32>,
    /// Fraction bits of `R_remain` and its constants, or of the power of two
    /// that the pieces take; the default follows n, F and tail.
    pub constant_bits: Option<u32>,
    /// `R_accum` starts at 1 plus this many units of its last bit.
    pub offset: Option<i32>,
}

impl Default for ExpConfig {
    fn default() -> Self {
        Self {
            form: ExpForm::Restoring,
            output: ExpOutput::Alpha,
            base: ExpBase::E,
            pieces: 64,
            iterations: 16,
            early_out: false,
            tail: false,
            iterations_per_clock: 1,
            pipelined: false,
            input: Format::unsigned(3, 13),
            output_bits: 16,
            one_minus_frac_bits: 20,
            accumulator_bits: None,
            constant_bits: None,
            offset: None,
        }
    }
}

/// Every derived width of the engine. Both sides build from these numbers and
/// compute their own constants.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Engine {
    /// Fraction bits of `R_accum`.
    pub accumulator_bits: u32,
    /// Fraction bits of `R_remain` and of the constants.
    pub constant_bits: u32,
    /// Start of `R_accum`, in units of its last bit above 1.
    pub offset: i32,
    /// Whether the truncation is centred: `2^-(n+1)` is added at the start.
    /// Without tail only, and where the constants reach that far.
    pub centred: bool,
    /// Exponent digits `ln 2 * 2^j`, `j = digits-1 .. 0`; of radix 4, `4^j`.
    pub digits: u32,
    /// Start of `R_remain` in units of `ln 2`.
    pub bias: u32,
    /// Steps in all: `digits + n`.
    pub steps: u32,
}

impl ExpConfig {
    /// Bits that the iterations resolve: n, or two for every digit of radix 4.
    #[must_use]
    pub fn resolved_bits(&self) -> u32 {
        match self.form {
            ExpForm::Radix4 => 2 * self.iterations,
            _ => self.iterations,
        }
    }

    /// The engine that these knobs describe.
    #[must_use]
    pub fn engine(&self) -> Engine {
        if self.form == ExpForm::Piecewise {
            return self.piecewise_engine();
        }
        let (n, f) = (self.resolved_bits(), self.output_bits);
        let (digits, bias) = match (self.form, self.output) {
            (ExpForm::Literal | ExpForm::Piecewise, _) => (0, 0),
            (ExpForm::Radix4, _) => (2, 12),
            (ExpForm::Restoring, ExpOutput::Alpha) => (4, 12),
            (ExpForm::Restoring, ExpOutput::General) => {
                // x in [-2^I, 2^I): a bias of ceil(2^I / ln 2) makes the start
                // non-negative, and the digits must reach twice as far.
                let reach = 2f64.powi(self.input.int_bits() as i32) / std::f64::consts::LN_2;
                let bias = reach.ceil() as u32;
                ((2 * bias + 1).ilog2() + 1, bias)
            }
        };
        let known = match self.form {
            ExpForm::Radix4 => known_radix4_widths(self.iterations, f, self.tail),
            _ => known_widths(n, f, self.tail),
        };
        // Past the table: guard bits that keep every term of the error budget
        // but the truncation below a quarter unit.
        let guard = (2 * (n + 4)).ilog2() + 1;
        let accumulator_bits = self
            .accumulator_bits
            .unwrap_or(known.map_or(f + guard, |k| k.0));
        let constant_bits = self
            .constant_bits
            .unwrap_or(known.map_or((f + guard).max(n + 1), |k| k.1))
            .max(self.input.frac_bits());
        let steps = digits + self.iterations;
        Engine {
            accumulator_bits,
            constant_bits,
            offset: self.offset.unwrap_or(known.map_or(0, |k| k.2)),
            centred: !self.tail && self.form != ExpForm::Literal && constant_bits > n,
            digits,
            bias,
            steps,
        }
    }

    /// What is done to a power, clock by clock: its clocks are the initiation interval of the
    /// iterative form, and its stages those of the pipelined one.
    #[must_use]
    pub fn power_pipeline(&self) -> Pipeline<PowerStage> {
        match self.form {
            ExpForm::Piecewise => Pipeline::power_of_two(self.base == ExpBase::Two),
            _ => {
                let a_clock = self.iterations_per_clock.max(1);
                Pipeline::recurrence(self.engine().steps.div_ceil(a_clock), self.tail)
            }
        }
    }

    /// Clocks from the acceptance of an exponential to the next one's: the initiation interval
    /// of the iterative form, and the stages of the pipelined one.
    #[must_use]
    pub fn interval(&self) -> u32 {
        self.power_pipeline().cycles()
    }

    /// The passes of an operation through the iterative engine.
    #[must_use]
    pub fn passes(&self, op: OpCode) -> Passes {
        Passes::of(op, &self.power_pipeline())
    }

    /// Clocks from the acceptance of an exponential whose result is
    /// `mantissa 2^-k` to the next one's: the interval, or fewer with an early
    /// out.
    #[must_use]
    pub fn clocks_of(&self, k: u32) -> u32 {
        let interval = self.interval();
        if !self.early_out {
            return interval;
        }
        let wanted = (self.output_bits + 2).saturating_sub(k);
        let steps = self.engine().digits + wanted.min(self.iterations);
        let clocks = steps.div_ceil(self.iterations_per_clock.max(1));
        clocks.max(self.earliest_out()).min(interval)
    }

    /// Clocks after which the exponent's digits are complete.
    #[must_use]
    pub fn digit_clocks(&self) -> u32 {
        let digits = self.engine().digits;
        digits.div_ceil(self.iterations_per_clock.max(1))
    }

    /// The fewest clocks that an early out can take.
    #[must_use]
    pub fn earliest_out(&self) -> u32 {
        self.digit_clocks() + AGREEMENT
    }
}

/// Smallest widths of radix 4, found likewise for `n = 2 J`.
fn known_radix4_widths(digits: u32, f: u32, tail: bool) -> Option<(u32, u32, i32)> {
    match (f, digits, tail) {
        // 0.788, 0.986 and 0.732 ulp.
        (16, 4, true) => Some((18, 20, 1)),
        (16, 8, false) => Some((20, 19, -1)),
        (16, 5, true) => Some((17, 20, 0)),
        // Below 1 ulp.
        (8, 4, false) => Some((11, 13, 0)),
        (8, 2, true) => Some((8, 13, 0)),
        _ => None,
    }
}

/// Smallest widths found by exhaustive search over the 65,536 inputs of U3.13:
/// accumulator bits, constant bits, offset. The search and what it aims at for
/// each n are `potamoi_reference::widths`.
fn known_widths(n: u32, f: u32, tail: bool) -> Option<(u32, u32, i32)> {
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
