//! Sequencing of the engine: begin, steps, multiplication and end, cycle by cycle.

use potamoi_formats::config::{Config, ExpConfig};
use potamoi_formats::timing::Pass;
use potamoi_formats::units::OpCode;
use potamoi_netlist::{ModuleBuilder, Signal, Ty};

use super::exponential::early_out::incomplete;
use crate::circuits::{is, plus_one};

/// Sequencing of the engine.
pub(super) struct Sequence {
    /// The result is complete at the end of this cycle.
    pub(super) done: Signal,
    pub(super) step: Signal,
    pub(super) begin: Signal,
    pub(super) tail: Signal,
    pub(super) rotate: Signal,
    pub(super) busy: Signal,
    pub(super) log: Option<Log>,
    /// With early termination, the register of the last phase.
    pub(super) ending: Option<Signal>,
}

impl Sequence {
    /// Ends the vector in the next clock if no lane has `more` steps after it. A lane has more
    /// until its exponent is known.
    pub(super) fn end(
        &self,
        m: &mut ModuleBuilder,
        exp: &ExpConfig,
        phase: Signal,
        more: Option<Signal>,
    ) {
        let Some(ending) = self.ending else { return };
        let open = incomplete(m, exp, phase);
        let mut goes_on = vec![open, ending];
        goes_on.extend(more.map(|lanes| m.any(lanes)));
        let goes_on = m.any_of(&goes_on);
        let ends = m.not(goes_on);
        let ends = m.and(self.step, ends);
        m.set_next(ending, ends);
    }
}

/// Sequencing of sigmoid and softplus after their first exponential.
pub(super) struct Log {
    /// Whether this cycle's steps are the logarithm's.
    pub(super) steps: Signal,
    /// Whether they are the logarithm's first; in a registered unit, the clock before.
    pub(super) begin: Signal,
    /// Whether this cycle's steps are the first of sigmoid's second exponential.
    pub(super) again: Option<Signal>,
    /// In a registered unit, the clock before these.
    pub(super) load_again: Option<Signal>,
    /// In a registered unit, the clock after the logarithm, in which the sum is registered.
    pub(super) sum: Option<Signal>,
}

/// Whether the vector has a certain operation.
#[derive(Clone, Copy)]
pub(super) struct Order {
    /// For the offered vector.
    pub(super) now: Signal,
    /// For the last accepted vector.
    pub(super) held: Signal,
}

/// The offered operation.
#[derive(Clone, Copy)]
pub(super) struct Offer {
    pub(super) accept: Signal,
    /// Whether the engine computes it.
    pub(super) is_exp: Signal,
}

impl Offer {
    /// Whether the engine begins it.
    fn begins(self, m: &mut ModuleBuilder) -> Signal {
        let begin = m.and(self.accept, self.is_exp);
        m.name(begin, "begin_power")
    }
}

/// Whether the engine is within an operation, and whether an operation's phases pass.
fn runs(m: &mut ModuleBuilder, free: Signal, begin: Signal, name: &str) -> [Signal; 2] {
    let busy = m.not(free);
    let busy = m.name(busy, "mid_power");
    let runs = m.or(begin, busy);
    let runs = m.name(runs, name);
    [busy, runs]
}

/// Counts the phases. Returns whether a result is complete.
fn count(m: &mut ModuleBuilder, phase: Signal, runs: Signal, last: Signal, offer: Offer) -> Signal {
    let next = plus_one(m, phase);
    let zero = m.lit(0, phase.ty());
    let next = m.mux(last, zero, next);
    m.set_next_if(phase, runs, next);
    let plain = m.not(offer.is_exp);
    let plain = m.and(offer.accept, plain);
    let done = m.or(plain, last);
    m.name(done, "done")
}

/// Sequencing of operations of one pass.
pub(super) fn sequence(
    m: &mut ModuleBuilder,
    config: &Config,
    phase: Option<Signal>,
    free: Signal,
    offer: Offer,
    interval: u32,
) -> Sequence {
    let begin = offer.begins(m);
    let never = m.lit(0, Ty::bit());
    let Some(phase) = phase else {
        return Sequence {
            done: offer.accept,
            step: begin,
            begin,
            tail: never,
            rotate: begin,
            busy: never,
            log: None,
            ending: None,
        };
    };
    let [busy, step] = runs(m, free, begin, "step");
    let (last, ending) = if config.vu.exp.early_out {
        let ending = m.reg("last_phase", Ty::bit(), 0);
        (ending, Some(ending))
    } else {
        let last = is(m, phase, interval - 1);
        (m.name(last, "last_phase"), None)
    };
    let done = count(m, phase, step, last, offer);
    let (tail, rotate) = if config.vu.exp.tail {
        let early = m.not(last);
        (last, m.and(step, early))
    } else {
        (never, step)
    };
    Sequence {
        done,
        step,
        begin,
        tail,
        rotate,
        busy,
        log: None,
        ending,
    }
}

/// As [`sequence`], for operations of one, two and three passes.
pub(super) fn passes(
    m: &mut ModuleBuilder,
    config: &Config,
    phase: Signal,
    free: Signal,
    offer: Offer,
    [sigmoid, softplus]: [Option<Order>; 2],
) -> Sequence {
    let (vu, exp) = (&config.vu, &config.vu.exp);
    let of_sigmoid = vu.passes(OpCode::Sigmoid);
    let clocks = |pass| of_sigmoid.clocks(pass).unwrap_or_default();
    let [power, logarithm, second] = [Pass::Power, Pass::Logarithm, Pass::SecondPower].map(clocks);
    let begin = offer.begins(m);
    // Between passes no step is taken: a registered unit's registers are passed.
    let mut between: Vec<u32> = (power.end..logarithm.start).collect();
    if vu.registered {
        between.extend(match sigmoid {
            Some(_) => logarithm.end..second.start,
            None => logarithm.end..logarithm.end + 1,
        });
    }
    let (busy, runs, step) = if between.is_empty() {
        let [busy, step] = runs(m, free, begin, "step");
        (busy, step, step)
    } else {
        let [busy, runs] = runs(m, free, begin, "runs");
        let between: Vec<_> = between.into_iter().map(|at| is(m, phase, at)).collect();
        let between = m.any_of(&between);
        let between = m.name(between, "between_passes");
        let steps = m.not(between);
        let step = m.and(runs, steps);
        (busy, runs, m.name(step, "step"))
    };

    let mut end = m.lit(exp.interval() - 1, phase.ty());
    for (order, op) in [(sigmoid, OpCode::Sigmoid), (softplus, OpCode::Softplus)] {
        let Some(order) = order else { continue };
        let here = m.mux(free, order.now, order.held);
        let own = m.lit(vu.passes(op).cycles() - 1, phase.ty());
        end = m.mux(here, own, end);
    }
    let end = m.name(end, "end_phase");
    let ends = m.eq(phase, end);
    let last = m.and(runs, ends);
    let last = m.name(last, "last_phase");
    let done = count(m, phase, runs, last, offer);

    // Sigmoid begins as softplus does, and goes on from there.
    let from = m.lit(logarithm.start, phase.ty());
    let mut steps = m.ge(phase, from);
    let log = match vu.registered {
        true => {
            let load = is(m, phase, logarithm.start - 1);
            m.name(load, "load_log")
        }
        false => {
            let log = m.eq(phase, from);
            m.name(log, "begin_log")
        }
    };
    let mut tails = vec![is(m, phase, power.end - 1)];
    let again = sigmoid.map(|_| {
        let to = m.lit(second.start, phase.ty());
        let before = m.lt(phase, to);
        steps = m.and(steps, before);
        tails.push(is(m, phase, second.end - 1));
        let again = m.eq(phase, to);
        m.name(again, "begin_again")
    });
    let load_again = again.filter(|_| vu.registered).map(|_| {
        let load = is(m, phase, second.start - 1);
        m.name(load, "load_again")
    });
    let sum = vu.registered.then(|| {
        let sum = is(m, phase, logarithm.end);
        m.name(sum, "take_sum")
    });
    let steps = m.name(steps, "log_steps");
    let (tail, rotate) = if exp.tail {
        let tail = m.any_of(&tails);
        let tail = m.name(tail, "tail_now");
        let turns = m.not(tail);
        (tail, m.and(step, turns))
    } else {
        (m.lit(0, Ty::bit()), step)
    };
    Sequence {
        done,
        step,
        begin,
        tail,
        rotate,
        busy,
        log: Some(Log {
            steps,
            begin: log,
            again,
            load_again,
            sum,
        }),
        ending: None,
    }
}
