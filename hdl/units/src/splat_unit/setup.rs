//! Start values of an entry's forms, its limit, and the rows that it may reach.

use std::sync::Arc;

use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::formats::{AT_ROW, Widths};
use super::limits::{Limit, Table};
use super::masks::up_to;
use super::near::near;
use super::root::{self, root};
use super::start_values::{Multiplied, PHASES, SUMMED, Start, start_values};
use crate::circuits::{bits_for, is, plus_one};

/// Clocks of settling after which the rows in reach are found. The start value of `q`, and the limit's
/// root, were there when settling began.
const SEARCHED: u32 = 1;
/// Clocks of settling after which the start value of `p` is there.
const WHOLE: u32 = SUMMED - 1;
/// Clocks of settling after which the entry is offered.
const SETTLES: u32 = WHOLE + 1;

// The limit is read and subtracted in two clocks before its root.
const _: () = assert!(root::CLOCKS + 2 <= PHASES);

/// A record as it comes in, by field.
struct Record {
    mean: [Signal; 2],
    factor: [Signal; 3],
    opacity: Signal,
    colour: Signal,
}

impl Record {
    fn of(m: &mut ModuleBuilder, data: Signal) -> Self {
        let mut at = 0;
        let mut field = |m: &mut ModuleBuilder, name: &str, bits: u32| {
            at += bits;
            let field = m.slice(data, at - bits, bits);
            m.name(field, name)
        };
        let mut signed = |m: &mut ModuleBuilder, name: &str| {
            let bits = field(m, name, 32);
            m.as_signed(bits)
        };
        let mean = ["mean_x", "mean_y"].map(|name| signed(m, name));
        let factor = ["first_l11", "first_l21", "first_l22"].map(|name| signed(m, name));
        Self {
            mean,
            factor,
            opacity: field(m, "first_opacity", 16),
            colour: field(m, "first_colour", 48),
        }
    }
}

/// An entry at the input.
struct Offered {
    valid: Signal,
    data: Signal,
    slot: Signal,
    tile: [Signal; 2],
    last: [Signal; 2],
}

/// The entry that is multiplied.
struct First {
    held: Signal,
    phase: Signal,
    begins_phase: Signal,
    ready: Signal,
    leaves: Signal,
    slot: Signal,
    tile: [Signal; 2],
    last: [Signal; 2],
    fields: Record,
}

/// When the entry that settles does what.
struct Settling {
    settling: Signal,
    settled: Signal,
    is_settled: Signal,
}

/// Builds `splat_setup`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn setup(w: &Widths) -> Result<Arc<Module>, IrErrors> {
    let mut builder = ModuleBuilder::new("splat_setup");
    let m = &mut builder;
    m.doc("start values of a record's forms in a tile, its limit, and the rows that it may reach.");
    let bit = Ty::bit();
    let offered = Offered {
        valid: m.input("valid", bit, "an entry"),
        data: m.input("record", Ty::u(224), "the record without its rank"),
        slot: m.input("slot", Ty::u(w.slot), "number of its tile"),
        tile: ["tile_x", "tile_y"].map(|name| m.input(name, Ty::u(12), "place of the tile")),
        last: ["last_x", "last_y"].map(|name| m.input(name, Ty::u(4), "of the tile's pixels")),
    };
    let centred = m.input("centred", bit, "pixel centres lie at half a pixel");
    let taken = m.input("out_ready", bit, "the next stage takes the entry");
    let alive = m.input(
        "rows_alive",
        Ty::u(16),
        "rows of the offered tile with live pixels",
    );
    let table = Table::declare(m, w)?;

    m.section("Entry that is multiplied");
    let state = settling(m);
    let first = first(m, &offered, state.settling);
    let entry = Multiplied {
        tile: first.tile,
        centred,
        mean: first.fields.mean,
        factor: first.fields.factor,
        phase: first.phase,
        begins_phase: first.begins_phase,
    };
    let [p, q] = start_values(m, &entry)?;
    let begins = is(m, first.phase, 0);
    let begins = m.and(first.held, begins);
    let begins = m.name(begins, "looks_up");
    let stored = table.look_up(m, begins, first.fields.opacity);

    m.section("Entry that settles");
    let leaves = first.leaves;
    let keep = |m: &mut ModuleBuilder, name: &str, value: Signal| {
        let register = m.data_reg(name, value.ty());
        m.set_next_if(register, leaves, value);
        register
    };
    let slot = keep(m, "slot_2", first.slot);
    let factors = [0, 1, 2].map(|i| keep(m, ["l11", "l21", "l22"][i], first.fields.factor[i]));
    let opacity = keep(m, "opacity", first.fields.opacity);
    let colour = keep(m, "colour", first.fields.colour);
    let last = [0, 1].map(|i| keep(m, ["last_column", "last_row"][i], first.last[i]));
    let found = Limit::kept(m, w, stored, leaves);
    let rows = rows_in_reach(m, &first, &q, &state, found.early)?;
    // Each is whole here, before that of the next entry begins.
    let q = hold(m, &state, ("q", 0), &q);
    let p = hold(m, &state, ("p", WHOLE), &p);
    let in_tile = up_to(m, last[1]);
    let rows = m.all_of(&[rows, in_tile, alive]);
    let rows = m.name(rows, "rows_found");
    let some = m.any(rows);
    let is_far = m.or(p.is_far, q.is_far);
    let is_near = m.not(is_far);
    let needed = m.all_of(&[some, found.counts, is_near]);
    let needed = m.name(needed, "is_needed");
    let shown = settle(m, &state, leaves, [needed, taken]);

    m.section("Outputs");
    m.output("ready", first.ready, "takes an entry at the clock edge");
    m.output("out_valid", shown, "an entry with rows");
    m.output("out_slot", slot, "");
    m.output("p_start", p.value, "at the tile's first pixel");
    m.output("q_start", q.value, "");
    for (name, factor) in ["out_l11", "out_l21", "out_l22"].into_iter().zip(factors) {
        m.output(name, factor, "");
    }
    m.output("out_opacity", opacity, "");
    m.output("out_colour", colour, "");
    m.output("out_last_x", last[0], "");
    m.output("out_limit", found.limit, "largest power that counts");
    m.output("out_search", found.search, "the same, for the search");
    m.output("out_rows", rows, "to be searched");
    let busy = m.or(first.held, state.settling);
    m.output("busy", busy, "holds an entry");
    builder.finish()
}

/// The entry that is multiplied: a phase a clock; it leaves in the last one, if none settles.
fn first(m: &mut ModuleBuilder, offered: &Offered, settling: Signal) -> First {
    let held = m.reg("held", Ty::bit(), 0);
    let phase = m.reg("phase", Ty::u(3), 0);
    let at_end = is(m, phase, PHASES - 1);
    let at_end = m.name(at_end, "last_phase");
    let not_settling = m.not(settling);
    let leaves = m.all_of(&[held, at_end, not_settling]);
    let leaves = m.name(leaves, "leaves");
    let not_held = m.not(held);
    let ready = m.or(not_held, leaves);
    let ready = m.name(ready, "is_ready");
    let accept = m.and(offered.valid, ready);
    let accept = m.name(accept, "accept");
    let more = m.or(accept, held);
    let not_leaves = m.not(leaves);
    let stays = m.or(accept, not_leaves);
    let next_held = m.and(more, stays);
    m.set_next(held, next_held);
    let not_end = m.not(at_end);
    let counts = m.and(held, not_end);
    let counts = m.name(counts, "counts_on");
    let zero = m.lit(0, phase.ty());
    let more = plus_one(m, phase);
    let more = m.mux(counts, more, phase);
    let next = m.mux(accept, zero, more);
    m.set_next(phase, next);
    let mut take = |name: &str, value: Signal| {
        let register = m.data_reg(name, value.ty());
        m.set_next_if(register, accept, value);
        register
    };
    let record = take("first_record", offered.data);
    let slot = take("first_slot", offered.slot);
    let tile = [0, 1].map(|i| take(["first_tile_x", "first_tile_y"][i], offered.tile[i]));
    let last = [0, 1].map(|i| take(["first_last_x", "first_last_y"][i], offered.last[i]));
    First {
        held,
        phase,
        begins_phase: m.or(accept, counts),
        ready,
        leaves,
        slot,
        tile,
        last,
        fields: Record::of(m, record),
    }
}

/// Registers of the entry that settles.
fn settling(m: &mut ModuleBuilder) -> Settling {
    let settling = m.reg("settling", Ty::bit(), 0);
    let settled = m.reg("settled", Ty::u(bits_for(SETTLES)), 0);
    let is_settled = is(m, settled, SETTLES);
    Settling {
        settling,
        settled,
        is_settled: m.name(is_settled, "is_settled"),
    }
}

/// Rows of the tile at which `q` is near enough, held once they are found.
fn rows_in_reach(
    m: &mut ModuleBuilder,
    first: &First,
    q: &Start,
    state: &Settling,
    limit: Signal,
) -> Result<Signal, IrErrors> {
    let always = m.lit(1, Ty::bit());
    let links = [("advance", always), ("square", limit)];
    let limit_root = m.instance("limit_root", &root()?, &links);
    let limit_root = m.out(limit_root, "root");
    let begins = is(m, state.settled, 0);
    let begins = m.name(begins, "q_is_whole");
    let start = m.extend(q.value, AT_ROW);
    let links = [
        ("takes_step", first.leaves),
        ("takes_start", begins),
        ("takes_root", always),
        ("start", start),
        ("step", first.fields.factor[2]),
        ("root", limit_root),
    ];
    let rows = m.instance("rows_near", &near()?, &links);
    let rows = m.out(rows, "near");
    let are_found = is(m, state.settled, SEARCHED);
    let register = m.data_reg("rows_in_reach", rows.ty());
    m.set_next_if(register, are_found, rows);
    Ok(register)
}

/// A start value, held in a clock of settling.
fn hold(m: &mut ModuleBuilder, state: &Settling, (name, clock): (&str, u32), of: &Start) -> Start {
    let now = is(m, state.settled, clock);
    let now = m.name(now, &format!("holds_{name}"));
    let mut register = |name: String, value: Signal| {
        let register = m.data_reg(&name, value.ty());
        m.set_next_if(register, now, value);
        register
    };
    Start {
        value: register(format!("{name}_first"), of.value),
        is_far: register(format!("{name}_is_far"), of.is_far),
    }
}

/// Settling: it ends when the entry is taken, or is not needed. Returns whether an entry is offered.
fn settle(
    m: &mut ModuleBuilder,
    state: &Settling,
    leaves: Signal,
    [needed, taken]: [Signal; 2],
) -> Signal {
    let Settling {
        settling,
        settled,
        is_settled,
    } = *state;
    let offered = m.all_of(&[settling, is_settled, needed]);
    let offered = m.name(offered, "offered");
    let dropped = m.not(needed);
    let gone = m.or(dropped, taken);
    let ends = m.all_of(&[settling, is_settled, gone]);
    let ends = m.name(ends, "ends");
    let not_ends = m.not(ends);
    let still = m.and(settling, not_ends);
    let next = m.or(leaves, still);
    m.set_next(settling, next);
    let not_yet = m.not(is_settled);
    let counts = m.and(settling, not_yet);
    let more = plus_one(m, settled);
    let zero = m.lit(0, settled.ty());
    let more = m.mux(counts, more, settled);
    let next = m.mux(leaves, zero, more);
    m.set_next(settled, next);
    offered
}
