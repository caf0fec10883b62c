//! Restoring with two bits a step: factors `1 + d 4^-j`, d in 0..=3, j = 1..iterations, after two
//! digits of `4^j ln 2`.

use super::engine::Engine;
use super::form::{Form, Offers};
use super::knobs::ExpConfig;
use super::recurrence::{self, Recurrence};
use crate::timing::{Pipeline, PowerStage};

pub(super) struct Radix4;

impl Form for Radix4 {
    fn offers(&self) -> Offers {
        Offers {
            one_minus: true,
            tail: true,
            ..Offers::default()
        }
    }

    fn engine(&self, exp: &ExpConfig) -> Engine {
        let own = Recurrence {
            digits: 2,
            bias: 12,
            known: known_widths(exp.iterations, exp.output_bits, exp.tail),
            centres: true,
        };
        own.engine(exp, self.resolved_bits(exp))
    }

    fn stages(&self, exp: &ExpConfig) -> Pipeline<PowerStage> {
        recurrence::stages(exp)
    }

    fn resolved_bits(&self, exp: &ExpConfig) -> u32 {
        2 * exp.iterations
    }

    fn iterations(&self) -> (u32, u32, &'static str) {
        (1, 15, "digits of radix 4, whose shift amount has 5 bits")
    }

    fn plain(&self, exp: &mut ExpConfig) {
        exp.iterations = 8;
    }
}

/// Smallest widths for a number of digits, found by the search of [`recurrence::known_widths`].
fn known_widths(digits: u32, f: u32, tail: bool) -> Option<(u32, u32, i32)> {
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
