//! The engine's registers: r steps a clock, pass after pass.

use potamoi_formats::config::Config;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::constants::multiples;
use super::early_out::Own;
use super::form::{Powers, Recurrence, Shift, State, StepInputs, Widths};
use super::logistic::Passes;
use super::shift_registers::sub_name;
use crate::circuits::held as registered;
use crate::vector_unit::lane_control::LaneControl;

/// Control signals of the steps, for all lanes.
struct StepSignals {
    step: Signal,
    begin: Signal,
    /// In a registered unit, a clock before `begin`: the start is registered.
    load: Option<Signal>,
    tail: Option<Signal>,
    own: Option<Own>,
    places: Vec<StepInputs>,
    passes: Option<Passes>,
}

impl StepSignals {
    fn declare(
        own: &dyn Recurrence,
        m: &mut ModuleBuilder,
        config: &Config,
        widths: &Widths,
    ) -> Self {
        let exp = &config.vu.exp;
        let step = m.input("step", Ty::bit(), "takes steps this cycle");
        let begin = m.input(
            "begin_power",
            Ty::bit(),
            "this cycle's steps start from the operand",
        );
        let load = config.vu.registered.then(|| {
            m.input(
                "load_power",
                Ty::bit(),
                "takes the start of the operand at the clock edge",
            )
        });
        let tail = exp.tail.then(|| {
            m.input(
                "tail",
                Ty::bit(),
                "multiplies by 1 + the residual this cycle",
            )
        });
        Self {
            step,
            begin,
            load,
            tail,
            own: exp.early_out.then(|| Own::declare(m, exp)),
            places: (0..exp.iterations_per_clock)
                .map(|i| {
                    let place = place(own, m, widths, i);
                    match config.vu.registered {
                        true => place.held(m, i),
                        false => place,
                    }
                })
                .collect(),
            passes: Passes::declare(m, widths, config.vu.registered),
        }
    }
}

/// What this cycle's steps start from.
struct Start {
    regs: State,
    now: State,
    /// The remainder that the operand starts from.
    first: Signal,
    /// From the operand, or as sigmoid's second exponential.
    begin: Signal,
    large: Signal,
    /// In a registered unit, whether the registers take the start at the clock edge.
    load: Option<Signal>,
    /// Of sigmoid and softplus in a registered unit: whether the registers take the logarithm's start
    /// at the clock edge, and that start.
    log: Option<(Signal, State)>,
    /// Of sigmoid and softplus: the register that says so of a power of 8 and more.
    rescaled: Option<Signal>,
    /// Of sigmoid and softplus: the power, and the sum with the logarithm.
    logistic: Option<(Signal, Signal)>,
}

impl Start {
    fn build(
        own: &dyn Recurrence,
        m: &mut ModuleBuilder,
        widths: &Widths,
        control: &LaneControl,
        told: &StepSignals,
        a: Signal,
    ) -> Self {
        let passes = told.passes;
        // What sigmoid's second exponential starts from is in the registers.
        let early = passes.map(|passes| {
            let regs = registers(m, widths);
            m.section("Exponential: start");
            let (size, sum) = passes.sum(m, widths, a, told.load.unwrap_or(told.begin), regs);
            (regs, size, sum)
        });
        let size = early.map(|(_, size, _)| size);
        let (start, large) = widths.start(own, m, a, control.one_minus, size);
        m.section("Exponential: steps");
        let regs = match early {
            Some((regs, ..)) => regs,
            None => registers(m, widths),
        };
        let again = passes.and_then(|p| p.again);
        let begin = match (again, told.load) {
            (Some(again), None) => m.or(told.begin, again),
            _ => told.begin,
        };
        let mut now = match told.load {
            // The register of the remainder has the start already.
            Some(_) => {
                let remain = regs.remain;
                from(m, begin, State { remain, ..start }, regs)
            }
            None => from(m, begin, start, regs),
        };
        let mut rescaled = None;
        let (mut log, mut logistic) = (None, None);
        if let (Some(passes), Some((_, _, sum))) = (passes, early) {
            let held = m.data_reg("r_rescaled", Ty::bit());
            rescaled = Some(held);
            let mut power = widths.scaled(m, regs, held);
            if told.load.is_some() {
                power = registered(m, "r_power", power);
            }
            let start = widths.start_log(m, power, now.digits);
            if told.load.is_some() {
                log = Some((passes.begin_log, start));
            } else {
                now.remain = m.mux(passes.begin_log, start.remain, now.remain);
                now.accum = m.mux(passes.begin_log, start.accum, now.accum);
            }
            logistic = Some((power, sum));
        }
        let load = told.load.map(|load| match again {
            Some(again) => m.or(load, again),
            None => load,
        });
        Self {
            regs,
            now: State {
                remain: m.name(now.remain, "remain_now"),
                accum: m.name(now.accum, "accum_now"),
                digits: m.name(now.digits, "digits_now"),
            },
            first: start.remain,
            begin,
            large,
            load,
            rescaled,
            log,
            logistic,
        }
    }
}

fn registers(m: &mut ModuleBuilder, widths: &Widths) -> State {
    State {
        remain: m.data_reg("r_remain", widths.remain),
        accum: m.data_reg("r_accum", widths.accum),
        digits: m.data_reg("r_digits", widths.digits),
    }
}

/// Registers that the steps run in, r a clock. The first steps take the
/// operand itself, so that loading costs no cycle.
pub(super) fn iterative(
    own: &dyn Recurrence,
    m: &mut ModuleBuilder,
    config: &Config,
    widths: &Widths,
    control: &LaneControl,
    a: Signal,
) -> Powers {
    m.section(if widths.kinds.logistic() {
        "Exponential: registers"
    } else {
        "Exponential: start"
    });
    let told = StepSignals::declare(own, m, config, widths);
    let start = Start::build(own, m, widths, control, &told, a);
    let (regs, begin) = (start.regs, start.begin);
    let mut state = start.now;
    for (i, place) in told.places.iter().enumerate() {
        state = own.step(
            m,
            widths,
            state,
            place,
            i as u32,
            told.passes.map(|p| p.log),
        );
    }
    if let Some(now) = told.tail {
        let end = widths.tail(m, regs);
        state = State {
            accum: m.mux(now, end.accum, state.accum),
            ..state
        };
        // The residual and the digits stay as they are for the last clock.
        state.digits = m.mux(now, regs.digits, state.digits);
    }
    let step = match &told.own {
        Some(own) => own.steps(m, told.step, begin),
        None => told.step,
    };
    let log = start.log.map(|(load, log)| (load, [log.remain, log.accum]));
    let first = start.load.map(|load| (load, start.first));
    let [of_log, accum_of_log] = [0, 1].map(|i| log.map(|(load, starts)| (load, starts[i])));
    let loads: Vec<_> = first.into_iter().chain(of_log).collect();
    take(m, regs.remain, step, state.remain, &loads);
    take(m, regs.accum, step, state.accum, accum_of_log.as_slice());
    m.set_next_if(regs.digits, step, state.digits);
    let large = if widths.kinds.one_minus || start.rescaled.is_some() {
        let held = start
            .rescaled
            .unwrap_or_else(|| m.data_reg("r_rescaled", Ty::bit()));
        let large = match start.load {
            // The last power is scaled as the next one is loaded.
            Some(load) => {
                let loaded = m.data_reg("loaded_rescaled", Ty::bit());
                m.set_next_if(loaded, load, start.large);
                loaded
            }
            None => start.large,
        };
        m.set_next_if(held, begin, large);
        held
    } else {
        start.large
    };
    let exponent = told
        .own
        .is_some()
        .then(|| widths.exponent_of_digits(m, regs, large));
    let more = told
        .own
        .zip(exponent)
        .map(|(own, k)| own.more(m, &config.vu.exp, k, told.step));
    Powers {
        state: regs,
        large,
        logistic: start.logistic,
        exponent,
        more,
        remainders: vec![],
    }
}

/// Sets a register: what a step leaves, or what is loaded.
fn take(
    m: &mut ModuleBuilder,
    register: Signal,
    step: Signal,
    stepped: Signal,
    loads: &[(Signal, Signal)],
) {
    let (mut changes, mut next) = (step, stepped);
    for (load, start) in loads {
        next = m.mux(*load, *start, next);
        changes = m.or(*load, changes);
    }
    m.set_next_if(register, changes, next);
}

/// One state or the other.
fn from(m: &mut ModuleBuilder, take: Signal, one: State, other: State) -> State {
    State {
        remain: m.mux(take, one.remain, other.remain),
        accum: m.mux(take, one.accum, other.accum),
        digits: m.mux(take, one.digits, other.digits),
    }
}

impl StepInputs {
    /// A clock later, in registers of the lane: what all lanes share is far from each.
    fn held(self, m: &mut ModuleBuilder, i: u32) -> Self {
        let constants = self.constants.into_iter().enumerate();
        Self {
            constants: constants
                .map(|(at, constant)| registered(m, &format!("constant{at}_held{i}"), constant))
                .collect(),
            shift: match self.shift {
                Shift::Of(shift) => Shift::Of(registered(m, &format!("mul_held{i}"), shift)),
                fixed @ Shift::By(_) => fixed,
            },
            digit: registered(m, &format!("digit_held{i}"), self.digit),
        }
    }
}

fn place(own: &dyn Recurrence, m: &mut ModuleBuilder, widths: &Widths, i: u32) -> StepInputs {
    let none = m.lit(0, Ty::bit());
    StepInputs {
        constants: multiples(own)
            .map(|d| {
                m.input(
                    &format!("{}{i}", sub_name(d)),
                    widths.remain,
                    "what is compared and subtracted",
                )
            })
            .collect(),
        shift: Shift::Of(m.input(&format!("mul{i}"), widths.shift, "shift amount of r_accum")),
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
