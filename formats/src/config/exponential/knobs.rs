//! Knobs of the exponential engine.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::ExpForm;
use crate::fixed::Format;

/// Base of the operation `exp`.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum ExpBase {
    /// `exp(-u)`.
    E,
    /// `2^-u`: the producer of the operand folds `log2 e` into it.
    Two,
}

/// Output format of an exponential.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum ExpOutput {
    /// Unsigned input `u`, result `exp(-u)` in `U0.F`; 1 saturates at the largest code.
    Alpha,
    /// Signed input `x`, result `exp(x)` as exponent and mantissa: bits F..0 are a mantissa U1.F in
    /// [1, 2), the bits above are a signed exponent.
    General,
}

/// Knobs of the exponential engine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ExpConfig {
    /// Algorithm.
    pub form: ExpForm,
    /// Output format.
    pub output: ExpOutput,
    /// Base; two in the piecewise form only.
    pub base: ExpBase,
    /// Number of pieces in the piecewise form's table, a power of two.
    pub pieces: u32,
    /// Iterations `n` past the exponent's digits; digits `J` of radix 4.
    pub iterations: u32,
    /// Early termination: a power of exponent k takes only the iterations that its bits need,
    /// `min(n, F - k + 2)`; a vector takes as many as its longest lane.
    pub early_out: bool,
    /// Whether a final multiplication by 1 + the residual follows.
    pub tail: bool,
    /// Iterations a clock, `r`.
    pub iterations_per_clock: u32,
    /// Whether the engine is pipelined, with one result a clock and a stage for each clock's
    /// iterations.
    pub pipelined: bool,
    /// Input format: unsigned for alpha, signed for general. Its fraction bits
    /// are also those of the operands of sigmoid and softplus.
    pub input: Format,
    /// Fraction bits `F` of the result.
    pub output_bits: u32,
    /// Fraction bits of the input of `1 - exp(-s)`, whose range is 0..16.
    pub one_minus_frac_bits: u32,
    /// Fraction bits of `R_accum`, or of a piece's start; by default they follow from n, F and
    /// tail.
    pub accumulator_bits: Option<u32>,
    /// Fraction bits of `R_remain` and its constants, or of the exponent of two that the pieces
    /// take; by default they follow from n, F and tail.
    pub constant_bits: Option<u32>,
    /// Initial `R_accum` above 1, in units of its last bit.
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
