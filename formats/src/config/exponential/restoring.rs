//! Restoring, correct for negative exponents: digits of `k ln 2` first, then `ln(1 + 2^-i)`, i =
//! 1..n.

use super::engine::Engine;
use super::form::{Form, Offers};
use super::knobs::{ExpConfig, ExpOutput};
use super::recurrence::{self, Recurrence, known_widths};
use crate::timing::{Pipeline, PowerStage};

pub(super) struct Restoring;

impl Form for Restoring {
    fn offers(&self) -> Offers {
        Offers {
            general: true,
            base_two: false,
            one_minus: true,
            tail: true,
            early_out: true,
            logistic: true,
        }
    }

    fn engine(&self, exp: &ExpConfig) -> Engine {
        let (digits, bias) = match exp.output {
            ExpOutput::Alpha => (4, 12),
            ExpOutput::General => {
                // x in [-2^I, 2^I): a bias of ceil(2^I / ln 2) makes the start
                // non-negative, and the digits must reach twice as far.
                let reach = 2f64.powi(exp.input.int_bits() as i32) / std::f64::consts::LN_2;
                let bias = reach.ceil() as u32;
                ((2 * bias + 1).ilog2() + 1, bias)
            }
        };
        let own = Recurrence {
            digits,
            bias,
            known: known_widths(exp.iterations, exp.output_bits, exp.tail),
            centres: true,
        };
        own.engine(exp, exp.iterations)
    }

    fn stages(&self, exp: &ExpConfig) -> Pipeline<PowerStage> {
        recurrence::stages(exp)
    }
}
