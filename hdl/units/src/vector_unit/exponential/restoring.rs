//! The restoring form: compare, subtract, shift and add.

use num_bigint::BigInt;
use potamoi_formats::config::{Engine, ExpConfig, ExpOutput};
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::constants::ln_two_times;
use super::form::{Recurrence, State, StepInputs, Widths, renamed};

pub(super) struct Restoring;

impl Recurrence for Restoring {
    fn registers(&self, exp: &ExpConfig, engine: &Engine) -> [Ty; 2] {
        // Integer bits of the start, 12 ln 2 = 8.3 or 24 ln 2 - 8 = 8.6 in the
        // alpha configuration, x + Z ln 2 in the general one.
        let integer = match exp.output {
            ExpOutput::Alpha => 4,
            ExpOutput::General => exp.input.int_bits() + 2,
        };
        let remain = Ty::u(engine.constant_bits + integer);
        [remain, Ty::u(engine.accumulator_bits + 2)]
    }

    fn digits_width(&self, engine: &Engine) -> u32 {
        engine.digits
    }

    fn leaves(&self, most: &BigInt, constants: &[BigInt]) -> Option<BigInt> {
        let constant = &constants[0];
        let taken = most - constant;
        Some(taken.max((constant - 1u32).min(most.clone())))
    }

    fn bias(&self, z: u32, bits: u32) -> BigInt {
        let digits = (0..32).filter(|j| z >> j & 1 == 1);
        digits.map(|j| ln_two_times(j, bits)).sum()
    }

    /// A step of a logarithm is taken where the sum stays below 2.
    fn step(
        &self,
        m: &mut ModuleBuilder,
        widths: &Widths,
        s: State,
        place: &StepInputs,
        index: u32,
        log: Option<Signal>,
    ) -> State {
        let constant = place.constants[0];
        let mut take = m.ge(s.remain, constant);
        let mut early = None;
        if let Some(log) = log {
            let sum = widths.grown(m, s, place, index, true);
            let sum = m.name(sum, &format!("accum_grown{index}"));
            // Doubled by a digit's step, a sum of 2 and more wraps.
            let top = widths.accum.width - 1;
            let (past, before) = (m.bit(sum, top), m.bit(s.accum, top));
            let past = m.or(past, before);
            let below = m.not(past);
            take = m.mux(log, below, take);
            early = Some(sum);
        }
        let take = m.name(take, &format!("take{index}"));
        let less = m.sub(s.remain, constant);
        let remain = m.mux(take, less, s.remain);
        let remain = m.name(remain, &format!("remain{index}"));
        let sum = early.unwrap_or_else(|| widths.grown(m, s, place, index, true));
        let multiply = m.not(place.digit);
        let multiply = m.and(take, multiply);
        let accum = m.mux(multiply, sum, s.accum);
        let accum = renamed(m, accum, s.accum, &format!("accum{index}"));
        let rest = m.slice(s.digits, 0, widths.digits.width - 1);
        let pushed = m.cat(&[rest, take]);
        let digits = m.mux(place.digit, pushed, s.digits);
        let digits = renamed(m, digits, s.digits, &format!("digits{index}"));
        State {
            remain,
            accum,
            digits,
        }
    }
}
