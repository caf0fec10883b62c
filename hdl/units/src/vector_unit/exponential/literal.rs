//! The recurrence as printed in the paper: a signed exponent, no rounding, no digits.

use num_bigint::BigInt;
use potamoi_formats::config::{Engine, ExpConfig};
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::form::{Recurrence, State, StepInputs, Widths};

pub(super) struct Literal;

impl Recurrence for Literal {
    fn registers(&self, _: &ExpConfig, engine: &Engine) -> [Ty; 2] {
        let remain = Ty::s(engine.constant_bits + 2);
        [remain, Ty::u(engine.accumulator_bits + 3)]
    }

    fn digits_width(&self, _: &Engine) -> u32 {
        1
    }

    fn first(&self) -> u32 {
        0
    }

    fn is_literal(&self) -> bool {
        true
    }

    fn bias(&self, _: u32, _: u32) -> BigInt {
        BigInt::ZERO
    }

    fn step(
        &self,
        m: &mut ModuleBuilder,
        widths: &Widths,
        s: State,
        place: &StepInputs,
        index: u32,
        _: Option<Signal>,
    ) -> State {
        let constant = place.constants[0];
        let take = m.ge(s.remain, constant);
        let take = m.name(take, &format!("take{index}"));
        let less = m.sub(s.remain, constant);
        let remain = m.mux(take, less, s.remain);
        let remain = m.name(remain, &format!("remain{index}"));
        let sum = widths.grown(m, s, place, index, false);
        let accum = m.mux(take, sum, s.accum);
        State {
            remain,
            accum: m.name(accum, &format!("accum{index}")),
            digits: s.digits,
        }
    }
}
