//! Early termination: a lane stops once the bits of its power are complete, and a vector ends once
//! all its lanes have stopped.

use potamoi_formats::config::ExpConfig;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use crate::circuits::{bits_for, plus_one};

/// Largest exponent: the larger start is 24 ln 2.
const EXPONENTS: u32 = 24;

/// Termination of one lane. It stops independently, so that its result does not depend on its
/// neighbours.
pub(super) struct Own {
    phase: Signal,
    running: Signal,
}

impl Own {
    pub(super) fn declare(m: &mut ModuleBuilder, exp: &ExpConfig) -> Self {
        let phase = m.input("phase", phase_ty(exp), "clocks since the exponential began");
        let running = m.reg("r_running", Ty::bit(), 0);
        m.note(running, "this power has steps left");
        Self { phase, running }
    }

    /// Whether this lane steps when the vector does.
    pub(super) fn steps(&self, m: &mut ModuleBuilder, step: Signal, begin: Signal) -> Signal {
        let own = m.or(begin, self.running);
        let own = m.and(step, own);
        m.name(own, "step_own")
    }

    /// Whether a power with exponent k has steps left after the next clock.
    pub(super) fn more(
        self,
        m: &mut ModuleBuilder,
        exp: &ExpConfig,
        k: Signal,
        step: Signal,
    ) -> Signal {
        let ends: Vec<_> = (0..=EXPONENTS)
            .map(|k| m.lit(exp.clocks_of(k) - 1, self.phase.ty()))
            .collect();
        let end = m.select(k, &ends);
        let end = m.name(end, "last_phase");
        m.note(end, "by the exponent, once its digits are complete");
        let open = incomplete(m, exp, self.phase);
        let left = m.lt(self.phase, end);
        let left = m.or(open, left);
        m.set_next_if(self.running, step, left);
        let next = plus_one(m, self.phase);
        let next = m.name(next, "next_phase");
        let more = m.lt(next, end);
        m.or(open, more)
    }
}

/// Whether the exponent's digits are incomplete.
pub(in crate::vector_unit) fn incomplete(
    m: &mut ModuleBuilder,
    exp: &ExpConfig,
    phase: Signal,
) -> Signal {
    let complete = m.lit(exp.digit_clocks(), phase.ty());
    let open = m.lt(phase, complete);
    m.name(open, "digits_open")
}

/// Type of the clock counter of an exponential.
pub(super) fn phase_ty(exp: &ExpConfig) -> Ty {
    Ty::u(bits_for(exp.interval().saturating_sub(1)))
}
