//! One lane: the element-wise operations and the exponential engine.

use std::sync::Arc;

use potamoi_formats::config::{Config, ExpForm};
use potamoi_formats::timing::PowerStage;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::alu::{EXACT, exact, requantise};
use super::constants::{Step, steps};
use super::iterative::iterative;
use super::kinds::Kinds;
use super::orders::Orders;
use super::pieces::pieces;
use super::widths::Powers;
use super::widths::{Place, State, Widths};

/// Builds `vector_lane`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn lane(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let exp = &config.vu.exp;
    let kinds = Kinds::of(config);
    let widths = Widths::of(exp, kinds);
    let mut builder = ModuleBuilder::new("vector_lane");
    let m = &mut builder;
    m.doc("one lane of the vector unit: element-wise operations and the exponential engine.");
    let orders = Orders::declare(m, kinds);
    let a = m.input("a", Ty::s(32), "");
    let b = m.input("b", Ty::s(32), "");
    let reads_b = config.vu.ops.iter().any(|o| o.takes_both());
    if !reads_b {
        m.unused(b, "No operation that is built takes a second operand.");
    }
    if !kinds.elementwise {
        m.unused(
            orders.accept,
            "The exponential engine is told when to begin instead.",
        );
    }
    let plain = kinds.elementwise.then(|| {
        m.section("Element-wise operations");
        let next = exact(m, &config.vu.ops, orders.code, a, b);
        let held = m.reg("exact", EXACT, 0);
        m.set_next_if(held, orders.accept, next);
        held
    });
    let powers = kinds.exp.then(|| {
        if exp.form == ExpForm::Piecewise {
            pieces(m, &widths, &orders, a)
        } else if exp.pipelined {
            pipelined(m, config, &widths, &orders, a)
        } else {
            iterative(m, config, &widths, &orders, a)
        }
    });
    m.section("Result stage");
    let value = plain.map(|held| requantise(m, held, orders.shift, orders.rounding));
    let value = match (value, exp.pipelined && kinds.exp) {
        (Some(v), true) => Some(delay(m, v, exp.interval() - 1)),
        (v, _) => v,
    };
    let more = powers.as_ref().and_then(|p| p.more);
    let power = powers.map(|p| {
        let result = widths.result(m, &p, orders.was_one_minus);
        match p.logistic.filter(|_| kinds.softplus) {
            Some((_, sum)) => {
                let softplus = widths.softplus(m, sum);
                m.mux(orders.was_softplus, softplus, result)
            }
            None => result,
        }
    });
    let result = match (value, power) {
        (Some(v), Some(p)) => m.mux(orders.is_exp, p, v),
        (Some(only), None) | (None, Some(only)) => only,
        (None, None) => m.lit(0, Ty::u(32)),
    };
    m.output("result", result, "of the result stage");
    if let Some(more) = more {
        m.output("more", more, "has steps to take after the next clock");
    }
    builder.finish()
}

/// The value, `cycles` later.
fn delay(m: &mut ModuleBuilder, value: Signal, cycles: u32) -> Signal {
    (0..cycles).fold(value, |from, i| {
        let reg = m.reg(&format!("value_{i}"), from.ty(), 0);
        m.set_next(reg, from);
        reg
    })
}

/// A register stage for every clock's worth of steps.
fn pipelined(
    m: &mut ModuleBuilder,
    config: &Config,
    widths: &Widths,
    orders: &Orders,
    a: Signal,
) -> Powers {
    m.section("Exponential: start");
    let exp = &config.vu.exp;
    let r = exp.iterations_per_clock as usize;
    let (mut state, mut large) = widths.start(m, a, orders.one_minus, None);
    let all = steps(exp, widths.remain.width);
    let mut stage = 0;
    let mut hold = |m: &mut ModuleBuilder, s: State, large: Signal| {
        let mut reg = |name: &str, value: Signal| {
            let reg = m.reg(&format!("{name}_{stage}"), value.ty(), 0);
            m.set_next(reg, value);
            reg
        };
        let held = State {
            remain: reg("s_remain", s.remain),
            accum: reg("s_accum", s.accum),
            digits: reg("s_digits", s.digits),
        };
        let large = if widths.kinds.one_minus {
            reg("s_rescaled", large)
        } else {
            large
        };
        stage += 1;
        (held, large)
    };
    for stage in exp.power_pipeline().stages() {
        state = match stage {
            PowerStage::Steps(clock) => {
                m.section(&format!("Exponential: stage {clock}"));
                let of_clock = all.iter().enumerate().skip(clock as usize * r).take(r);
                of_clock.fold(state, |state, (index, step)| {
                    let place = literal_place(m, widths, step);
                    widths.step(m, state, &place, index as u32, None)
                })
            }
            PowerStage::Tail => {
                m.section("Exponential: tail");
                widths.tail(m, state)
            }
            // Not of the recurrence.
            PowerStage::PowerOfTwo | PowerStage::Mantissa => continue,
        };
        (state, large) = hold(m, state, large);
    }
    Powers {
        state,
        large,
        logistic: None,
        exponent: None,
        more: None,
    }
}

/// A place of the shift registers whose constants stay.
fn literal_place(m: &mut ModuleBuilder, widths: &Widths, step: &Step) -> Place {
    let constants = step.constants.iter();
    Place {
        constants: constants.map(|c| m.lit(c.clone(), widths.remain)).collect(),
        shift: m.lit(step.shift, widths.shift),
        digit: m.lit(u8::from(step.digit), Ty::bit()),
    }
}
