//! Exponentials of powers: packs powers into vectors for the lanes, and keeps what belongs to each.

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_formats::units::OpCode;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::formats::Widths;
use super::packing_checks::{Filling, packing_checks};
use crate::circuits::{bits_for, is, ones, plus_one};
use crate::fifo::fifo;
use crate::vector_unit::{depth, vector_unit};

/// Bits of an operand or a result of the vector unit.
const LANE: u32 = 32;

/// The exponential's unit: lanes that compute nothing else.
fn lanes_of(config: &Config, w: &Widths) -> Config {
    let mut own = config.clone();
    own.vu.lanes = w.lanes;
    own.vu.ops = vec![OpCode::Exp];
    own.vu.operands = None;
    own
}

/// Builds `splat_powers`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn powers(config: &Config, w: &Widths) -> Result<Arc<Module>, IrErrors> {
    let own = lanes_of(config, w);
    let lanes = w.lanes;
    let mut builder = ModuleBuilder::new("splat_powers");
    let m = &mut builder;
    m.doc("exponentials of powers, in order: vectors of as many powers as there are lanes.");
    let bit = Ty::bit();
    let valid = m.input("valid", bit, "a power");
    let power = m.input("power", Ty::u(w.power), "");
    let info = m.input("info", Ty::u(w.info()), "of its pair");
    let flush = m.input(
        "flush",
        bit,
        "no further power is on its way: the last vector is filled up",
    );
    let pop = m.input("pop", bit, "the vector that is offered is taken");

    m.section("Vector that is filled: its first lane is lowest");
    let count = m.reg("count", Ty::u(bits_for(lanes)), 0);
    let full = is(m, count, lanes);
    let full = m.name(full, "full");
    let in_flight = m.reg("in_flight", Ty::u(bits_for(depth(&own))), 0);
    let most = is(m, in_flight, depth(&own));
    let has_room = m.not(most);
    let sends = m.and(full, has_room);
    let sends = m.name(sends, "sends");
    let lit = |m: &mut ModuleBuilder, value: u64, bits: u32| m.lit(value, Ty::u(bits));
    let unit = vector_unit(&own)?.prefixed("splat_");
    let exponentials = m.instance("exponentials", &unit, &[]);
    // A pipelined exponential takes every vector for which it has room.
    let sent = match config.vu.exp.pipelined {
        true => sends,
        false => {
            let takes = m.out(exponentials, "s_axis_vec_tready");
            m.and(sends, takes)
        }
    };
    let sent = m.name(sent, "sent");
    let not_full = m.not(full);
    let ready = m.or(not_full, sent);
    let ready = m.name(ready, "is_ready");
    let accepts = m.and(valid, ready);
    let accepts = m.name(accepts, "accepts");
    let not_valid = m.not(valid);
    let begun = m.any(count);
    let pads = m.all_of(&[flush, not_valid, begun, not_full]);
    let pads = m.name(pads, "pads");
    let shifts = m.or(accepts, pads);
    let shifts = m.name(shifts, "shifts");
    let none = lit(m, 0, count.width());
    let held = m.mux(sent, none, count);
    let held = m.name(held, "count_held");
    let more = plus_one(m, held);
    let next = m.mux(shifts, more, held);
    m.set_next(count, next);
    let shift = |m: &mut ModuleBuilder, name: &str, value: Signal| {
        let width = value.width();
        let all = m.data_reg(name, Ty::u(lanes * width));
        let next = match lanes {
            1 => value,
            _ => {
                let above = m.slice(all, width, (lanes - 1) * width);
                m.cat(&[value, above])
            }
        };
        m.set_next_if(all, shifts, next);
        all
    };
    let powers = shift(m, "powers", power);
    let own_info = m.cat(&[accepts, info]);
    let held_infos = shift(m, "infos", own_info);

    m.section("Exponentials, and what belongs to them");
    let zero = lit(m, 0, 2 * LANE - w.power);
    let operands: Vec<Signal> = (0..lanes)
        .rev()
        .flat_map(|lane| [zero, m.slice(powers, lane * w.power, w.power)])
        .collect();
    let operands = m.cat(&operands);
    let keep = m.lit(ones(8 * lanes), Ty::u(8 * lanes));
    let code = u64::from(OpCode::Exp.code());
    let [off, on, user] = [(0, 1), (1, 1), (code, 12)].map(|(v, bits)| lit(m, v, bits));
    for (port, signal) in [
        ("cfg_clear", off),
        ("s_axis_vec_tvalid", sends),
        ("s_axis_vec_tdata", operands),
        ("s_axis_vec_tkeep", keep),
        ("s_axis_vec_tlast", on),
        ("s_axis_vec_tuser", user),
        ("m_axis_vec_tready", pop),
    ] {
        m.connect(exponentials, port, signal);
    }
    let words = fifo("splat_info_fifo", depth(&own), held_infos.width())?;
    let words = m.instance(
        "info_fifo",
        &words,
        &[("push", sent), ("push_data", held_infos), ("pop", pop)],
    );
    let one = lit(m, 1, in_flight.width());
    let (more, less) = (m.add(in_flight, one), m.sub(in_flight, one));
    let next = m.mux(sent, more, less);
    let changes = m.xor(sent, pop);
    m.set_next_if(in_flight, changes, next);

    m.section("Outputs");
    m.output("ready", ready, "takes a power at the clock edge");
    let offered = m.out(exponentials, "m_axis_vec_tvalid");
    m.output("out_valid", offered, "a vector of results");
    let results = m.out(exponentials, "m_axis_vec_tdata");
    let results: Vec<Signal> = (0..lanes)
        .rev()
        .map(|lane| m.slice(results, LANE * lane, w.exponential))
        .collect();
    let results = m.cat(&results);
    m.output("out_results", results, "the first lane lowest");
    let infos = m.out(words, "data");
    m.output(
        "out_infos",
        infos,
        "likewise; the highest bit of each says that it is a pair",
    );
    let flying = m.any(in_flight);
    let busy = m.or(begun, flying);
    m.output("busy", busy, "holds powers or results");
    let filling = Filling {
        powers,
        infos: held_infos,
        count,
        lanes,
        depth: depth(&own),
    };
    packing_checks(m, (exponentials, words), &filling);
    builder.finish()
}
