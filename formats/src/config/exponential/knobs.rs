//! The exponential engine's knobs.

use serde::{Deserialize, Serialize};

use super::ExpForm;
use crate::fixed::Format;

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
