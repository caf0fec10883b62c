//! What a form of the exponential decides.

use super::engine::Engine;
use super::knobs::{ExpConfig, ExpOutput};
use crate::config::breaches::RuleBreaches;
use crate::fixed::Format;
use crate::timing::{Pipeline, PowerStage};

/// What a form offers beyond `exp` of the alpha output.
#[derive(Debug, Clone, Copy, Default)]
pub struct Offers {
    /// The general output.
    pub general: bool,
    /// Powers of two.
    pub base_two: bool,
    /// The operation `one-minus-exp`.
    pub one_minus: bool,
    /// The multiplication at the end.
    pub tail: bool,
    /// An early out.
    pub early_out: bool,
    /// Sigmoid and softplus.
    pub logistic: bool,
}

/// How a form finds powers: its widths, its stages and its rules.
pub(super) trait Form: Sync {
    /// What it offers.
    fn offers(&self) -> Offers;

    /// The widths that the knobs imply.
    fn engine(&self, exp: &ExpConfig) -> Engine;

    /// What is done to a power, clock by clock.
    fn stages(&self, exp: &ExpConfig) -> Pipeline<PowerStage>;

    /// Bits of the power that the iterations resolve.
    fn resolved_bits(&self, exp: &ExpConfig) -> u32 {
        exp.iterations
    }

    /// Least and most iterations, and why.
    fn iterations(&self) -> (u32, u32, &'static str) {
        (2, 31, "the shift amount has 5 bits")
    }

    /// Whether an operand's format is right, and which are.
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

    /// The fewest fraction bits of the constants, and why.
    fn least_constant_bits(&self, exp: &ExpConfig) -> (u32, &'static str) {
        (exp.input.frac_bits(), "at least the input's fraction bits")
    }

    /// Rules of its own.
    fn rules(&self, exp: &ExpConfig, out: &mut RuleBreaches) {
        let _ = (exp, out);
    }

    /// Knobs of a plain engine of this form, from the default ones.
    fn plain(&self, exp: &mut ExpConfig) {
        let _ = exp;
    }

    /// Gives knobs that it does not look at the value that they have in `plain`.
    fn forget(&self, exp: &mut ExpConfig, plain: &ExpConfig) {
        exp.pieces = plain.pieces;
    }
}
