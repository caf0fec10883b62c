//! The recurrence as printed in the paper: `i = 0..n-1` on a signed exponent in [-1, 1). Every
//! constant is positive, so that negative exponents give 1. Kept as evidence.

use super::engine::Engine;
use super::form::{Form, Offers};
use super::knobs::{ExpConfig, ExpOutput};
use super::recurrence::{self, Recurrence, known_widths};
use crate::fixed::Format;
use crate::timing::{Pipeline, PowerStage};

pub(super) struct Literal;

impl Form for Literal {
    fn offers(&self) -> Offers {
        Offers {
            general: true,
            ..Offers::default()
        }
    }

    fn engine(&self, exp: &ExpConfig) -> Engine {
        let own = Recurrence {
            digits: 0,
            bias: 0,
            known: known_widths(exp.iterations, exp.output_bits, exp.tail),
            centres: false,
        };
        own.engine(exp, exp.iterations)
    }

    fn stages(&self, exp: &ExpConfig) -> Pipeline<PowerStage> {
        recurrence::stages(exp)
    }

    fn input(&self, input: Format, _: ExpOutput) -> (bool, &'static str) {
        (
            input.is_signed() && input.int_bits() == 0,
            "S0.4 to S0.24: the recurrence covers [-1, 1)",
        )
    }

    fn plain(&self, exp: &mut ExpConfig) {
        exp.input = Format::signed(0, 14);
    }
}
