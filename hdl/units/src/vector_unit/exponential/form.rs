//! Interface of a form of the exponential, and the registers of its engine.

use num_bigint::BigInt;
use potamoi_formats::config::{Config, Engine, ExpConfig};
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use crate::vector_unit::lane_control::LaneControl;
use crate::vector_unit::operation_kinds::OperationKinds;

/// Widths of the engine's registers.
#[derive(Clone)]
pub(in crate::vector_unit) struct Widths {
    /// The form built.
    pub(in crate::vector_unit) form: &'static dyn Form,
    pub(in crate::vector_unit) exp: ExpConfig,
    pub(in crate::vector_unit) engine: Engine,
    pub(in crate::vector_unit) remain: Ty,
    pub(in crate::vector_unit) accum: Ty,
    pub(in crate::vector_unit) digits: Ty,
    pub(in crate::vector_unit) shift: Ty,
    /// Kinds of operation built.
    pub(in crate::vector_unit) kinds: OperationKinds,
}

/// State before and after a step.
#[derive(Clone, Copy)]
pub(in crate::vector_unit) struct State {
    pub(in crate::vector_unit) remain: Signal,
    pub(in crate::vector_unit) accum: Signal,
    pub(in crate::vector_unit) digits: Signal,
}

/// Signals of one position of the shift registers.
#[derive(Clone)]
pub(in crate::vector_unit) struct StepInputs {
    /// One constant, or for radix 4 those of the digits 1, 2 and 3.
    pub(in crate::vector_unit) constants: Vec<Signal>,
    pub(in crate::vector_unit) shift: Shift,
    pub(in crate::vector_unit) digit: Signal,
}

/// Shift amount of a step: that of a stage is known, that of a shift register changes.
#[derive(Clone, Copy)]
pub(in crate::vector_unit) enum Shift {
    By(u32),
    Of(Signal),
}

/// Outputs of the engine for the result stage.
pub(in crate::vector_unit) struct Powers {
    pub(in crate::vector_unit) state: State,
    pub(in crate::vector_unit) large: Signal,
    /// For sigmoid and softplus, where built: the scaled power, and the sum that softplus rounds.
    pub(in crate::vector_unit) logistic: Option<(Signal, Signal)>,
    /// The exponent, where already known.
    pub(in crate::vector_unit) exponent: Option<Signal>,
    /// With early termination, whether steps are left after the next clock.
    pub(in crate::vector_unit) more: Option<Signal>,
    /// In a pipeline, the register of the remainder after each clock, and the most that it holds.
    pub(in crate::vector_unit) remainders: Vec<(String, BigInt)>,
}

/// Builds the powers of a form in a lane.
pub(in crate::vector_unit) trait Form: Sync {
    /// Description of the lane's engine.
    fn describe(&self) -> &'static str {
        "shift-register exponentials"
    }

    /// Types of `R_remain` and `R_accum`, or of the registers in their place.
    fn registers(&self, exp: &ExpConfig, engine: &Engine) -> [Ty; 2];

    /// Width of the exponent's digits in bits.
    fn digits_width(&self, engine: &Engine) -> u32;

    /// The engine of a lane with the operand `a`.
    fn powers(
        &self,
        m: &mut ModuleBuilder,
        config: &Config,
        widths: &Widths,
        control: &LaneControl,
        a: Signal,
    ) -> Powers;

    /// The exponent k: the power is `R_accum 2^-k`.
    fn exponent(&self, m: &mut ModuleBuilder, widths: &Widths, s: State, large: Signal) -> Signal;

    /// The shift registers of the iterative form, if any.
    fn recurrence(&self) -> Option<&dyn Recurrence> {
        None
    }

    /// Whether the result is the rounded accumulator for every output format.
    fn is_bare(&self) -> bool {
        false
    }
}

/// A form that compares, subtracts, shifts and adds.
pub(in crate::vector_unit) trait Recurrence: Sync {
    /// Types of `R_remain` and `R_accum`.
    fn registers(&self, exp: &ExpConfig, engine: &Engine) -> [Ty; 2];

    /// Width of the exponent's digits in bits.
    fn digits_width(&self, engine: &Engine) -> u32;

    /// Bits of the power resolved by a step.
    fn radix_bits(&self) -> u32 {
        1
    }

    /// Shift amount of the first step, in units of the radix.
    fn first(&self) -> u32 {
        1
    }

    /// Whether the remainder is signed, sums and start are unrounded, and the result is the
    /// accumulator.
    fn is_literal(&self) -> bool {
        false
    }

    /// The most that a step with these constants leaves of a remainder of at most `most`, where a
    /// comparison bounds it.
    fn leaves(&self, _most: &BigInt, _constants: &[BigInt]) -> Option<BigInt> {
        None
    }

    /// `z ln 2` as the sum of its digits, each rounded as the step's constant is.
    fn bias(&self, z: u32, bits: u32) -> BigInt;

    /// One step: with `log` high the sum decides instead of the comparison.
    fn step(
        &self,
        m: &mut ModuleBuilder,
        widths: &Widths,
        s: State,
        place: &StepInputs,
        index: u32,
        log: Option<Signal>,
    ) -> State;
}

/// Names what a step makes of a signal, unless it leaves it as it is.
pub(super) fn renamed(m: &mut ModuleBuilder, after: Signal, before: Signal, name: &str) -> Signal {
    match after == before {
        true => after,
        false => m.name(after, name),
    }
}
