//! The engine's registers: r steps a clock, pass after pass.

use potamoi_formats::config::Config;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::constants::multiples;
use super::control::sub_name;
use super::early_out::Own;
use super::logistic::Passes;
use super::orders::Orders;
use super::widths::Powers;
use super::widths::{Place, State, Widths};

/// Registers that the steps run in, r a clock. The first steps take the
/// operand itself, so that loading costs no cycle.
pub(super) fn iterative(
    m: &mut ModuleBuilder,
    config: &Config,
    widths: &Widths,
    orders: &Orders,
    a: Signal,
) -> Powers {
    m.section(if widths.kinds.logistic() {
        "Exponential: registers"
    } else {
        "Exponential: start"
    });
    let exp = &config.vu.exp;
    let step = m.input("step", Ty::bit(), "takes steps this cycle");
    let begin = m.input(
        "begin_power",
        Ty::bit(),
        "this cycle's steps start from the operand",
    );
    let tail = exp.tail.then(|| {
        m.input(
            "tail",
            Ty::bit(),
            "multiplies by 1 + the residual this cycle",
        )
    });
    let own = exp.early_out.then(|| Own::declare(m, exp));
    let ordered = step;
    let places: Vec<Place> = (0..exp.iterations_per_clock)
        .map(|i| place(m, widths, i))
        .collect();
    let passes = Passes::declare(m, widths);
    let registers = |m: &mut ModuleBuilder| State {
        remain: m.reg("r_remain", widths.remain, 0),
        accum: m.reg("r_accum", widths.accum, 0),
        digits: m.reg("r_digits", widths.digits, 0),
    };
    // What sigmoid's second exponential starts from is in the registers.
    let early = passes.map(|passes| {
        let regs = registers(m);
        m.section("Exponential: start");
        let (size, sum) = passes.sum(m, widths, a, begin, regs);
        (regs, size, sum)
    });
    let size = early.map(|(_, size, _)| size);
    let (start, large) = widths.start(m, a, orders.one_minus, size);
    m.section("Exponential: steps");
    let regs = match early {
        Some((regs, ..)) => regs,
        None => registers(m),
    };
    let begin = match passes.and_then(|p| p.begin_again) {
        Some(again) => m.or(begin, again),
        None => begin,
    };
    let mut state = from(m, begin, start, regs);
    let mut rescaled = None;
    let mut logistic = None;
    if let (Some(passes), Some((_, _, sum))) = (passes, early) {
        let held = m.reg("r_rescaled", Ty::bit(), 0);
        rescaled = Some(held);
        let power = widths.scaled(m, regs, held);
        let log = widths.start_log(m, power, state.digits);
        state.remain = m.mux(passes.begin_log, log.remain, state.remain);
        state.accum = m.mux(passes.begin_log, log.accum, state.accum);
        logistic = Some((power, sum));
    }
    state = State {
        remain: m.name(state.remain, "remain_now"),
        accum: m.name(state.accum, "accum_now"),
        digits: m.name(state.digits, "digits_now"),
    };
    for (i, place) in places.iter().enumerate() {
        state = widths.step(m, state, place, i as u32, passes.map(|p| p.log));
    }
    if let Some(now) = tail {
        let end = widths.tail(m, regs);
        state = State {
            accum: m.mux(now, end.accum, state.accum),
            ..state
        };
        // The residual and the digits stay as they are for the last clock.
        state.digits = m.mux(now, regs.digits, state.digits);
    }
    let step = match &own {
        Some(own) => own.steps(m, step, begin),
        None => step,
    };
    m.set_next_if(regs.remain, step, state.remain);
    m.set_next_if(regs.accum, step, state.accum);
    m.set_next_if(regs.digits, step, state.digits);
    let large = if widths.kinds.one_minus || rescaled.is_some() {
        let held = rescaled.unwrap_or_else(|| m.reg("r_rescaled", Ty::bit(), 0));
        m.set_next_if(held, begin, large);
        held
    } else {
        large
    };
    let exponent = own.is_some().then(|| widths.exponent(m, regs, large));
    let more = own
        .zip(exponent)
        .map(|(own, k)| own.more(m, exp, k, ordered));
    Powers {
        state: regs,
        large,
        logistic,
        exponent,
        more,
    }
}

/// One state or the other.
fn from(m: &mut ModuleBuilder, take: Signal, one: State, other: State) -> State {
    State {
        remain: m.mux(take, one.remain, other.remain),
        accum: m.mux(take, one.accum, other.accum),
        digits: m.mux(take, one.digits, other.digits),
    }
}

fn place(m: &mut ModuleBuilder, widths: &Widths, i: u32) -> Place {
    let none = m.lit(0, Ty::bit());
    Place {
        constants: multiples(widths.exp.form)
            .map(|d| {
                m.input(
                    &format!("{}{i}", sub_name(d)),
                    widths.remain,
                    "what is compared and subtracted",
                )
            })
            .collect(),
        shift: m.input(&format!("mul{i}"), widths.shift, "shift amount of r_accum"),
        digit: if widths.engine.digits > 0 {
            m.input(
                &format!("digit{i}"),
                Ty::bit(),
                "an exponent digit: r_accum stays",
            )
        } else {
            none
        },
    }
}
