//! The unit's top: acceptance, sequencing, lanes, output FIFO, counters.

use std::sync::Arc;

use potamoi_formats::config::{Config, ExpForm};
use potamoi_formats::units::{OpCode, VECTOR_UNIT};
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::alu::is_op;
use super::constants::multiples;
use super::control::{exp_constants, sub_name};
use super::kinds::Kinds;
use super::lane::lane;
use super::sequence::{Offer, Order, Sequence, passes, sequence};
use super::widths::Widths;
use crate::circuits::{bits_for, counter, fifo, is, sticky};

/// What is known of the vector in the result stage.
struct Tag {
    valid: Signal,
    /// A vector moves through the stages of the pipelined form.
    moving: Option<Signal>,
    is_exp: Signal,
    one_minus: Signal,
    shift: Signal,
    rounding: Signal,
    keep: Signal,
    last: Signal,
}

/// Builds the vector unit for a configuration.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub fn vector_unit(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let vu = &config.vu;
    let lanes = vu.lanes;
    let kinds = Kinds::of(config);
    let interval = if kinds.exp {
        vu.exp.engine().interval
    } else {
        1
    };
    let engine = vu.exp.engine();
    let longest = match (kinds.sigmoid, kinds.softplus) {
        (true, _) => engine.clocks(OpCode::Sigmoid),
        (_, true) => engine.clocks(OpCode::Softplus),
        _ => interval,
    };
    let pipelined = kinds.exp && vu.exp.pipelined;
    let lane_module = lane(config)?;
    let mut builder = ModuleBuilder::new(VECTOR_UNIT);
    let m = &mut builder;
    let powers = match vu.exp.form {
        ExpForm::Piecewise => "exponentials in straight pieces",
        _ => "shift-register exponentials",
    };
    m.doc(&format!(
        "{lanes} lanes of element-wise operations and {powers}, in lockstep."
    ));
    let bit = Ty::bit();
    let clear = m.input("cfg_clear", bit, "clears counters and flags");
    let valid = m.input("s_axis_vec_tvalid", bit, "operands");
    let data = m.input(
        "s_axis_vec_tdata",
        Ty::u(64 * lanes),
        "lane i: a in bits 64 i + 31 .. 64 i, b above",
    );
    let keep = m.input("s_axis_vec_tkeep", Ty::u(lanes), "lanes that hold elements");
    let last = m.input("s_axis_vec_tlast", bit, "passed on");
    let user = m.input(
        "s_axis_vec_tuser",
        Ty::u(12),
        "operation 4, shift 6, rounding 2 bits",
    );
    let sink = m.input("m_axis_vec_tready", bit, "");

    m.section("Acceptance");
    let code = m.slice(user, 0, 4);
    let code = m.name(code, "code");
    let shift = m.slice(user, 4, 6);
    let rounding = m.slice(user, 10, 2);
    let depth = vu.fifo_depth + if pipelined { interval + 1 } else { 0 };
    let inside_ty = Ty::u(bits_for(depth));
    let inside = m.reg("in_flight", inside_ty, 0);
    m.note(inside, "vectors accepted and not yet taken by the sink");
    let limit = m.lit(depth, inside_ty);
    let room = m.lt(inside, limit);
    let room = m.name(room, "room");
    let phase = (kinds.exp && !pipelined && longest > 1)
        .then(|| m.reg("phase", Ty::u(bits_for(longest - 1)), 0));
    let free = match phase {
        Some(p) => is(m, p, 0),
        None => m.lit(1, bit),
    };
    let free = if phase.is_some() {
        m.name(free, "engine_free")
    } else {
        free
    };
    let ready = m.and(room, free);
    let ready = m.name(ready, "may_accept");
    let accept = m.and(valid, ready);
    let accept = m.name(accept, "accept");
    let built: Vec<_> = vu.ops.iter().map(|op| is_op(m, code, *op)).collect();
    let mut named = |wanted: OpCode, name: &str| {
        let place = vu.ops.iter().position(|op| *op == wanted);
        match place {
            Some(i) => m.name(built[i], name),
            None => m.lit(0, bit),
        }
    };
    let power = named(OpCode::Exp, "is_power");
    let one_minus = named(OpCode::OneMinusExp, "is_one_minus");
    let sigmoid = named(OpCode::Sigmoid, "is_sigmoid");
    let softplus = named(OpCode::Softplus, "is_softplus");
    let is_exp = m.or(power, one_minus);
    let logistic = m.or(sigmoid, softplus);
    let logistic = if kinds.logistic() {
        m.name(logistic, "is_logistic")
    } else {
        logistic
    };
    let is_exp = m.or(is_exp, logistic);
    let is_exp = m.name(is_exp, "is_exp");

    m.section("Sequence of an exponential");
    let held = |m: &mut ModuleBuilder, built: bool, name: &str, value: Signal| {
        built.then(|| {
            let reg = m.reg(name, Ty::bit(), 0);
            m.set_next_if(reg, accept, value);
            Order {
                now: value,
                held: reg,
            }
        })
    };
    let sigmoid = held(m, kinds.sigmoid, "result_sigmoid", sigmoid);
    let softplus = held(m, kinds.softplus, "result_softplus", softplus);
    let offer = Offer { accept, is_exp };
    let sequence = match phase {
        Some(phase) if kinds.logistic() => {
            passes(m, config, phase, free, offer, [sigmoid, softplus])
        }
        _ => sequence(m, config, phase, free, offer, interval),
    };
    let tag = Tag::follow(
        m,
        &sequence,
        accept,
        interval,
        pipelined,
        [is_exp, one_minus, shift, rounding, keep, last],
    );

    let mut inputs: Vec<(String, Signal)> = vec![("accept".into(), accept)];
    if kinds.elementwise {
        inputs.extend([("code".into(), code)]);
        let (shift, rounding) = if pipelined {
            let early = |m: &mut ModuleBuilder, name: &str, from: Signal| {
                let reg = m.reg(name, from.ty(), 0);
                m.set_next(reg, from);
                reg
            };
            (
                early(m, "shift_next", shift),
                early(m, "rounding_next", rounding),
            )
        } else {
            (tag.shift, tag.rounding)
        };
        inputs.extend([("shift".into(), shift), ("rounding".into(), rounding)]);
        if kinds.exp {
            inputs.push(("result_is_exp".into(), tag.is_exp));
        }
    }
    if kinds.one_minus {
        inputs.extend([
            ("one_minus".into(), one_minus),
            ("result_is_one_minus".into(), tag.one_minus),
        ]);
    }
    if let Some(s) = softplus {
        inputs.push(("result_is_softplus".into(), s.held));
    }
    if let Some(log) = &sequence.log {
        inputs.extend([
            ("logistic".into(), logistic),
            ("log".into(), log.steps),
            ("begin_log".into(), log.begin),
        ]);
        if let (Some(s), true) = (sigmoid, kinds.softplus) {
            inputs.push(("sigmoid".into(), s.now));
        }
        if let Some(again) = log.again {
            inputs.push(("begin_again".into(), again));
        }
    }
    if kinds.exp && !pipelined {
        m.section("Constants, shared by the lanes");
        let widths = Widths::of(&vu.exp, kinds);
        let module = exp_constants(config, &widths)?;
        let constants = m.instance("constants", &module, &[("rotate", sequence.rotate)]);
        if let Some(ending) = sequence.ending {
            m.connect(constants, "restart", ending);
        }
        for i in 0..vu.exp.iterations_per_clock {
            let subs = multiples(vu.exp.form).map(sub_name);
            let digit = (widths.engine.digits > 0).then(|| "digit".to_owned());
            for name in subs.chain(["mul".to_owned()]).chain(digit) {
                let port = format!("{name}{i}");
                let value = m.out(constants, &port);
                inputs.push((port, value));
            }
        }
        inputs.extend([
            ("step".into(), sequence.step),
            ("begin_power".into(), sequence.begin),
        ]);
        if vu.exp.tail {
            inputs.push(("tail".into(), sequence.tail));
        }
        if let (Some(phase), Some(_)) = (phase, sequence.ending) {
            inputs.push(("phase".into(), phase));
        }
    }

    m.section("Lanes");
    let (mut results, mut more) = (vec![], vec![]);
    for i in 0..lanes {
        let a = m.slice(data, 64 * i, 32);
        let a = m.as_signed(a);
        let b = m.slice(data, 64 * i + 32, 32);
        let b = m.as_signed(b);
        let mut io: Vec<(&str, Signal)> = inputs.iter().map(|(n, s)| (n.as_str(), *s)).collect();
        io.extend([("a", a), ("b", b)]);
        let inst = m.instance(&format!("lane{i}"), &lane_module, &io);
        let result = m.out(inst, "result");
        let kept = m.bit(tag.keep, i);
        if sequence.ending.is_some() {
            let own = m.out(inst, "more");
            more.push(m.and(own, kept));
        }
        let mask = m.repeat(kept, 32);
        results.push(m.and(result, mask));
    }

    if let Some(phase) = phase {
        sequence.end(m, &vu.exp, phase, &more);
    }

    m.section("Results");
    results.reverse();
    let joined = m.cat(&results);
    let word = m.cat(&[tag.last, tag.keep, joined]);
    let module = fifo("result_fifo", depth, word.width())?;
    let fifo = m.instance("fifo", &module, &[("push", tag.valid), ("push_data", word)]);
    let offered = m.out(fifo, "valid");
    let pop = m.and(offered, sink);
    let pop = m.name(pop, "pop");
    m.connect(fifo, "pop", pop);
    let out = m.out(fifo, "data");
    let one = m.lit(1, inside_ty);
    let (more, less) = (m.add(inside, one), m.sub(inside, one));
    let next = m.mux(accept, more, less);
    let changes = m.xor(accept, pop);
    m.set_next_if(inside, changes, next);

    m.section("Counters and flags");
    let step = m.lit(1, bit);
    let vectors = counter(m, "stat_vectors", 32, clear, accept, step);
    let stepped = tag.moving.unwrap_or(sequence.busy);
    let active = m.or(accept, stepped);
    let busy = counter(m, "stat_busy", 32, clear, active, step);
    let no_room = m.not(room);
    let refused = m.all_of(&[valid, free, no_room]);
    let stall = counter(m, "stat_stall_out", 32, clear, refused, step);
    let built = m.any_of(&built);
    let not_built = m.not(built);
    let unknown = m.and(accept, not_built);
    let unknown = sticky(m, "operation_not_built", clear, unknown);
    let reserved = is(m, rounding, 3);
    let reserved = m.and(accept, reserved);
    let reserved = sticky(m, "rounding_reserved", clear, reserved);

    m.section("Outputs");
    m.output_low_in_reset("s_axis_vec_tready", ready, "does not depend on tvalid");
    m.output("m_axis_vec_tvalid", offered, "results");
    let width = 32 * lanes;
    let values = m.slice(out, 0, width);
    m.output(
        "m_axis_vec_tdata",
        values,
        "lane i in bits 32 i + 31 .. 32 i; lanes not kept are 0",
    );
    let kept = m.slice(out, width, lanes);
    m.output("m_axis_vec_tkeep", kept, "");
    let ends = m.bit(out, width + lanes);
    m.output("m_axis_vec_tlast", ends, "");
    m.output("stat_vectors", vectors, "vectors accepted");
    m.output(
        "stat_busy",
        busy,
        "cycles in which a vector is accepted or stepped",
    );
    m.output(
        "stat_stall_out",
        stall,
        "cycles in which only the lack of room refuses a vector",
    );
    let flags = m.cat(&[reserved, unknown]);
    m.output(
        "stat_errors",
        flags,
        "sticky: 1 reserved rounding code, 0 operation not built",
    );
    builder.finish()
}

impl Tag {
    /// Registers the tag beside the vector: once in the iterative form, through
    /// every stage in the pipelined one.
    fn follow(
        m: &mut ModuleBuilder,
        s: &Sequence,
        accept: Signal,
        interval: u32,
        pipelined: bool,
        values: [Signal; 6],
    ) -> Self {
        let names = ["is_exp", "one_minus", "shift", "rounding", "keep", "last"];
        let valid = m.reg("result_valid", Ty::bit(), 0);
        if !pipelined {
            m.set_next(valid, s.done);
            let held = std::array::from_fn(|i| {
                let reg = m.reg(&format!("result_{}", names[i]), values[i].ty(), 0);
                m.set_next_if(reg, accept, values[i]);
                reg
            });
            return Self::of(valid, None, held);
        }
        let (mut from_valid, mut from) = (accept, values);
        let mut stages = vec![];
        for stage in 1..interval {
            let reg = m.reg(&format!("valid_{stage}"), Ty::bit(), 0);
            m.set_next(reg, from_valid);
            from_valid = reg;
            stages.push(reg);
            from = std::array::from_fn(|i| {
                let reg = m.reg(&format!("{}_{stage}", names[i]), from[i].ty(), 0);
                m.set_next(reg, from[i]);
                reg
            });
        }
        m.set_next(valid, from_valid);
        let held = std::array::from_fn(|i| {
            let reg = m.reg(&format!("result_{}", names[i]), from[i].ty(), 0);
            m.set_next(reg, from[i]);
            reg
        });
        let moving = (!stages.is_empty()).then(|| {
            let moving = m.any_of(&stages);
            m.name(moving, "moving")
        });
        Self::of(valid, moving, held)
    }

    fn of(
        valid: Signal,
        moving: Option<Signal>,
        [is_exp, one_minus, shift, rounding, keep, last]: [Signal; 6],
    ) -> Self {
        Self {
            valid,
            moving,
            is_exp,
            one_minus,
            shift,
            rounding,
            keep,
            last,
        }
    }
}
