//! Pipelined engine: one register stage for each clock's steps.

use potamoi_formats::config::Config;
use potamoi_formats::timing::PowerStage;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::constants::{Step, steps};
use super::form::{Powers, Recurrence, Shift, State, StepInputs, Widths};
use crate::circuits::{delayed, held};
use crate::vector_unit::lane_control::LaneControl;

/// Builds one register stage for each clock's steps.
pub(super) fn pipelined(
    own: &dyn Recurrence,
    m: &mut ModuleBuilder,
    config: &Config,
    widths: &Widths,
    control: &LaneControl,
    a: Signal,
) -> Powers {
    m.section("Exponential: start");
    let exp = &config.vu.exp;
    let r = exp.iterations_per_clock as usize;
    let (mut state, mut large) = widths.start(own, m, a, control.one_minus, None);
    let all = steps(own, exp, widths.remain.width);
    let mut most = Some(widths.start_most(own));
    let mut remainders = vec![];
    if config.vu.registered {
        state.remain = held(m, "s_start", state.remain);
        if widths.kinds.one_minus {
            large = held(m, "rescaled_start", large);
        }
        remainders.extend(most.clone().map(|most| ("s_start".to_owned(), most)));
    }
    // Stages, and those since the last digit of the exponent.
    let (mut held, mut since_digits) = (0, 0);
    for stage in exp.power_pipeline().stages() {
        let digits = state.digits;
        state = match stage {
            PowerStage::Steps(clock) => {
                let of_clock = all.iter().enumerate().skip(clock as usize * r).take(r);
                let constants = of_clock.clone().map(|(_, step)| step.constant.as_str());
                let constants: Vec<_> = constants.collect();
                let constants = constants.join(", ");
                m.section(&format!("Exponential: stage {clock}: {constants}"));
                most = most.and_then(|most| {
                    let mut steps = of_clock.clone();
                    steps.try_fold(most, |most, (_, step)| own.leaves(&most, &step.constants))
                });
                remainders.extend(most.clone().map(|most| (format!("s_remain_{held}"), most)));
                of_clock.fold(state, |state, (index, step)| {
                    let place = literal_place(m, widths, step);
                    own.step(m, widths, state, &place, index as u32, None)
                })
            }
            PowerStage::Tail => {
                m.section("Exponential: tail");
                widths.tail(m, state)
            }
            // Not of the recurrence.
            PowerStage::PowerOfTwo | PowerStage::Mantissa => continue,
        };
        let is_digit = state.digits != digits;
        state = hold(m, state, held, is_digit);
        held += 1;
        since_digits = if is_digit { 0 } else { since_digits + 1 };
    }
    if !m.is_fixed(state.digits) {
        state.digits = delayed(m, "digits_stages", state.digits, since_digits, None).0;
    }
    let large = if widths.kinds.one_minus {
        delayed(m, "rescaled_stages", large, held, None).0
    } else {
        large
    };
    Powers {
        state,
        large,
        logistic: None,
        exponent: None,
        more: None,
        remainders,
    }
}

/// Registers the state after a stage, with the exponent's digits where there is a new one.
fn hold(m: &mut ModuleBuilder, state: State, stage: u32, is_digit: bool) -> State {
    let mut reg = |name: &str, value: Signal| {
        // The accumulator is at its start until the exponent's digits are known.
        if m.is_fixed(value) {
            return value;
        }
        let reg = m.data_reg(&format!("{name}_{stage}"), value.ty());
        m.set_next(reg, value);
        reg
    };
    State {
        remain: reg("s_remain", state.remain),
        accum: reg("s_accum", state.accum),
        digits: match is_digit {
            true => reg("s_digits", state.digits),
            false => state.digits,
        },
    }
}

/// A position of the shift registers with fixed constants.
fn literal_place(m: &mut ModuleBuilder, widths: &Widths, step: &Step) -> StepInputs {
    let constants = step.constants.iter();
    StepInputs {
        constants: constants.map(|c| m.lit(c.clone(), widths.remain)).collect(),
        shift: Shift::By(step.shift),
        digit: m.lit(u8::from(step.digit), Ty::bit()),
    }
}
