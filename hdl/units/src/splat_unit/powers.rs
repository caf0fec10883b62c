//! Exponentials of powers: packs powers into vectors for the lanes, and keeps what belongs to each.

use std::sync::Arc;

use potamoi_formats::config::{Config, SuConfig};
use potamoi_formats::units::OpCode;
use potamoi_netlist::{Instance, IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::formats::Widths;
use super::packing_checks::{Filling, packing_checks};
use crate::circuits::{bits_for, is, ones, plus_one};
use crate::fifo::fifo;
use crate::vector_unit::{depth, vector_unit};

/// Bits of an operand or a result of the vector unit.
const LANE: u32 = 32;

/// Builds `splat_powers`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn powers(config: &Config, su: &SuConfig, w: &Widths) -> Result<Arc<Module>, IrErrors> {
    let own = config.splat_lanes(su);
    let mut builder = ModuleBuilder::new("splat_powers");
    let m = &mut builder;
    m.doc("exponentials of powers, in order: vectors of as many powers as there are lanes.");
    let inputs = Inputs::declare(m, w);
    m.section("Vector that is filled: its first lane is lowest");
    let packed = packed(m, &own, &inputs)?;
    m.section("Exponentials, and what belongs to them");
    let words = connect(m, &own, w, (&inputs, &packed))?;

    m.section("Outputs");
    let Packed {
        exponentials,
        filling,
        begun,
        ..
    } = packed;
    m.output("ready", packed.ready, "takes a power at the clock edge");
    let offered = m.out(exponentials, "m_axis_vec_tvalid");
    m.output("out_valid", offered, "a vector of results");
    let results = m.out(exponentials, "m_axis_vec_tdata");
    let results: Vec<Signal> = (0..w.lanes)
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
    let flying = m.any(packed.in_flight);
    let busy = m.or(begun, flying);
    m.output("busy", busy, "holds powers or results");
    packing_checks(m, (exponentials, words), &filling);
    builder.finish()
}

/// Inputs of the module.
struct Inputs {
    valid: Signal,
    power: Signal,
    info: Signal,
    flush: Signal,
    pop: Signal,
}

impl Inputs {
    fn declare(m: &mut ModuleBuilder, w: &Widths) -> Self {
        let bit = Ty::bit();
        Self {
            valid: m.input("valid", bit, "a power"),
            power: m.input("power", Ty::u(w.power), ""),
            info: m.input("info", Ty::u(w.info()), "of its pair"),
            flush: m.input(
                "flush",
                bit,
                "no further power is on its way: the last vector is filled up",
            ),
            pop: m.input("pop", bit, "the vector that is offered is taken"),
        }
    }
}

/// The vector that is filled, and the lanes that it is sent to.
struct Packed {
    exponentials: Instance,
    filling: Filling,
    /// A power is taken.
    ready: Signal,
    /// A full vector, and room for its results.
    sends: Signal,
    /// The lanes take it.
    sent: Signal,
    /// It holds a power.
    begun: Signal,
    /// Number of vectors in the lanes.
    in_flight: Signal,
}

/// Packs powers into vectors, in order: each comes in at the last lane and moves down as others follow.
fn packed(m: &mut ModuleBuilder, own: &Config, inputs: &Inputs) -> Result<Packed, IrErrors> {
    let lanes = own.vu.lanes;
    let count = m.reg("count", Ty::u(bits_for(lanes)), 0);
    let full = is(m, count, lanes);
    let full = m.name(full, "full");
    let in_flight = m.reg("in_flight", Ty::u(bits_for(depth(own))), 0);
    let most = is(m, in_flight, depth(own));
    let has_room = m.not(most);
    let sends = m.and(full, has_room);
    let sends = m.name(sends, "sends");
    let unit = vector_unit(own)?.prefixed("splat_");
    let exponentials = m.instance("exponentials", &unit, &[]);
    // A pipelined exponential takes every vector for which it has room.
    let sent = match own.vu.exp.pipelined {
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
    let accepts = m.and(inputs.valid, ready);
    let accepts = m.name(accepts, "accepts");
    let not_valid = m.not(inputs.valid);
    let begun = m.any(count);
    let pads = m.all_of(&[inputs.flush, not_valid, begun, not_full]);
    let pads = m.name(pads, "pads");
    let shifts = m.or(accepts, pads);
    let shifts = m.name(shifts, "shifts");
    let none = m.lit(0, count.ty());
    let held = m.mux(sent, none, count);
    let held = m.name(held, "count_held");
    let more = plus_one(m, held);
    let next = m.mux(shifts, more, held);
    m.set_next(count, next);
    let powers = shifted_in(m, "powers", inputs.power, (lanes, shifts));
    let own_info = m.cat(&[accepts, inputs.info]);
    let infos = shifted_in(m, "infos", own_info, (lanes, shifts));
    Ok(Packed {
        exponentials,
        filling: Filling {
            powers,
            infos,
            count,
            lanes,
            depth: depth(own),
        },
        ready,
        sends,
        sent,
        begun,
        in_flight,
    })
}

/// A value a lane: what comes in is the highest one, and the others move down.
fn shifted_in(
    m: &mut ModuleBuilder,
    name: &str,
    value: Signal,
    (lanes, shifts): (u32, Signal),
) -> Signal {
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
}

/// Connects the lanes, and a FIFO of what belongs to their vectors, which is returned.
fn connect(
    m: &mut ModuleBuilder,
    own: &Config,
    w: &Widths,
    (inputs, packed): (&Inputs, &Packed),
) -> Result<Instance, IrErrors> {
    let (lanes, in_flight, sent) = (w.lanes, packed.in_flight, packed.sent);
    let lit = |m: &mut ModuleBuilder, value: u64, bits: u32| m.lit(value, Ty::u(bits));
    let zero = lit(m, 0, 2 * LANE - w.power);
    let operands: Vec<Signal> = (0..lanes)
        .rev()
        .flat_map(|lane| {
            [
                zero,
                m.slice(packed.filling.powers, lane * w.power, w.power),
            ]
        })
        .collect();
    let operands = m.cat(&operands);
    let keep = m.lit(ones(8 * lanes), Ty::u(8 * lanes));
    let code = u64::from(OpCode::Exp.code());
    let [off, on, user] = [(0, 1), (1, 1), (code, 12)].map(|(v, bits)| lit(m, v, bits));
    for (port, signal) in [
        ("cfg_clear", off),
        ("s_axis_vec_tvalid", packed.sends),
        ("s_axis_vec_tdata", operands),
        ("s_axis_vec_tkeep", keep),
        ("s_axis_vec_tlast", on),
        ("s_axis_vec_tuser", user),
        ("m_axis_vec_tready", inputs.pop),
    ] {
        m.connect(packed.exponentials, port, signal);
    }
    let infos = packed.filling.infos;
    let words = fifo("splat_info_fifo", depth(own), infos.width())?;
    let words = m.instance(
        "info_fifo",
        &words,
        &[("push", sent), ("push_data", infos), ("pop", inputs.pop)],
    );
    let one = lit(m, 1, in_flight.width());
    let (more, less) = (m.add(in_flight, one), m.sub(in_flight, one));
    let next = m.mux(sent, more, less);
    let changes = m.xor(sent, inputs.pop);
    m.set_next_if(in_flight, changes, next);
    Ok(words)
}
