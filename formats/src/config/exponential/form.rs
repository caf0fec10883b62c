//! Interface of a form of the exponential.

use super::engine::Engine;
use super::knobs::{ExpConfig, ExpOutput};
use crate::config::breaches::RuleBreaches;
use crate::fixed::Format;
use crate::timing::{Pipeline, PowerStage};

/// Optional features of a form, beyond `exp` with the alpha output.
#[derive(Debug, Clone, Copy, Default)]
pub struct Offers {
    /// The general output.
    pub general: bool,
    /// Powers of two.
    pub base_two: bool,
    /// The operation `one-minus-exp`.
    pub one_minus: bool,
    /// The final multiplication (tail).
    pub tail: bool,
    /// Early termination.
    pub early_out: bool,
    /// Sigmoid and softplus.
    pub logistic: bool,
}

/// A form of the exponential: its widths, stages and rules.
pub(super) trait Form: Sync {
    /// Optional features.
    fn offers(&self) -> Offers;

    /// Widths that follow from the knobs.
    fn engine(&self, exp: &ExpConfig) -> Engine;

    /// Stages of a power, clock by clock.
    fn stages(&self, exp: &ExpConfig) -> Pipeline<PowerStage>;

    /// Bits of the power that the iterations resolve.
    fn resolved_bits(&self, exp: &ExpConfig) -> u32 {
        exp.iterations
    }

    /// Smallest and largest number of iterations, and the reason.
    fn iterations(&self) -> (u32, u32, &'static str) {
        (2, 31, "the shift amount has 5 bits")
    }

    /// Whether an operand format is allowed, and the allowed ones.
    fn input(&self, input: Format, output: ExpOutput) -> (bool, &'static str) {
        match output {
            ExpOutput::Alpha => (
                !input.is_signed() && (1..=3).contains(&input.int_bits()),
                "U1.x to U3.x with 4 to 24 fraction bits: the digits cover 0 to 8",
            ),
            ExpOutput::General => (
                input.is_signed() && input.int_bits() <= 6,
                "S0.x to S6.x with 4 to 24 fraction bits",
            ),
        }
    }

    /// Smallest number of fraction bits of the constants, and the reason.
    fn least_constant_bits(&self, exp: &ExpConfig) -> (u32, &'static str) {
        (exp.input.frac_bits(), "at least the input's fraction bits")
    }

    /// Rules of this form only.
    fn rules(&self, exp: &ExpConfig, out: &mut RuleBreaches) {
        let _ = (exp, out);
    }

    /// Sets the knobs of this form's plain engine, from default ones.
    fn plain(&self, exp: &mut ExpConfig) {
        let _ = exp;
    }

    /// Resets unused knobs to their values in `plain`.
    fn forget(&self, exp: &mut ExpConfig, plain: &ExpConfig) {
        exp.pieces = plain.pieces;
    }
}
