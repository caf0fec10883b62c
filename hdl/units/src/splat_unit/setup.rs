//! Start values of an entry's forms, its limit, and the rows that it may reach.

use std::sync::Arc;

use potamoi_formats::record::MEAN;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::formats::{AT_ROW, START, STEP, Widths};
use super::limits::{Limit, Table};
use super::near::{near, up_to};
use super::root::{self, root};
use crate::circuits::{bits_for, is, plus_one};

/// Factors times halves of offsets: three products of two halves.
const PHASES: u32 = 6;
/// Clocks after which the rows in reach are found: the start values are there, and the limit's root,
/// which is begun in the last clock of the products.
const SEARCHED: u32 = root::CLOCKS - 1;
/// Clocks after which the entry is offered.
const SETTLES: u32 = SEARCHED + 1;
/// Clocks after which the sums of products are whole.
const SUMMED: u32 = 2;
/// Bits of an offset from the mean.
const OFFSET: u32 = 33;
/// Bits of the lower half of an offset.
const HALF: u32 = 16;

/// A record as it comes in, by field.
struct Record {
    mean: [Signal; 2],
    factor: [Signal; 3],
    opacity: Signal,
    colour: Signal,
}

impl Record {
    fn of(m: &mut ModuleBuilder, data: Signal) -> Self {
        let mut word = |at: u32| {
            let bits = m.slice(data, 32 * at, 32);
            m.as_signed(bits)
        };
        let (mean, factor) = ([word(0), word(1)], [word(2), word(3), word(4)]);
        Self {
            mean,
            factor,
            opacity: m.slice(data, 160, 16),
            colour: m.slice(data, 176, 48),
        }
    }
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
    let valid = m.input("valid", bit, "an entry");
    let data = m.input("record", Ty::u(224), "the record without its rank");
    let slot = m.input("slot", Ty::u(w.slot), "number of its tile");
    let tile = ["tile_x", "tile_y"].map(|name| m.input(name, Ty::u(12), "place of the tile"));
    let last = ["last_x", "last_y"].map(|name| m.input(name, Ty::u(4), "of the tile's pixels"));
    let centred = m.input("centred", bit, "pixel centres lie at half a pixel");
    let taken = m.input("out_ready", bit, "the next stage takes the entry");
    let alive = m.input(
        "rows_alive",
        Ty::u(16),
        "rows of the offered tile with live pixels",
    );
    let table = Table::declare(m, w)?;

    m.section("Entry that is multiplied");
    let held = m.reg("held", bit, 0);
    let phase = m.reg("phase", Ty::u(3), 0);
    let settling = m.reg("settling", bit, 0);
    let settled = m.reg("settled", Ty::u(bits_for(SETTLES)), 0);
    let at_end = is(m, phase, PHASES - 1);
    let at_end = m.name(at_end, "last_phase");
    let not_settling = m.not(settling);
    let leaves = m.all_of(&[held, at_end, not_settling]);
    let leaves = m.name(leaves, "leaves");
    let not_held = m.not(held);
    let ready = m.or(not_held, leaves);
    let ready = m.name(ready, "is_ready");
    let accept = m.and(valid, ready);
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
    let take = |m: &mut ModuleBuilder, name: &str, value: Signal| {
        let register = m.data_reg(name, value.ty());
        m.set_next_if(register, accept, value);
        register
    };
    let record = take(m, "first_record", data);
    let first_slot = take(m, "first_slot", slot);
    let tile = [0, 1].map(|i| take(m, ["first_tile_x", "first_tile_y"][i], tile[i]));
    let first_last = [0, 1].map(|i| take(m, ["first_last_x", "first_last_y"][i], last[i]));
    let fields = Record::of(m, record);

    m.section("Products: one half of an offset a clock");
    let offsets = [0, 1].map(|i| offset(m, tile[i], centred, fields.mean[i]));
    let [dx, dy] = [0, 1].map(|i| m.name(offsets[i], ["dx", "dy"][i]));
    let mut halves = vec![];
    for offset in [dx, dy, dy] {
        let low = m.slice(offset, 0, HALF);
        let low = m.extend(low, HALF + 1);
        halves.push(m.as_signed(low));
        let high = m.slice(offset, HALF, OFFSET - HALF);
        halves.push(m.as_signed(high));
    }
    let half = m.select(phase, &halves);
    let half = m.name(half, "next_half");
    let [l11, l21, l22] = fields.factor;
    let factor = m.select(phase, &[l11, l11, l21, l21, l22, l22]);
    let factor = m.name(factor, "next_factor");
    let half_reg = m.data_reg("half", half.ty());
    m.set_next(half_reg, half);
    let factor_reg = m.data_reg("factor", factor.ty());
    m.set_next(factor_reg, factor);
    let product = m.mul(factor_reg, half_reg);
    let product_reg = m.data_reg("product", product.ty());
    m.set_next(product_reg, product);
    let fresh = m.reg("fresh", bit, 0);
    let begins_phase = m.or(accept, counts);
    m.set_next(fresh, begins_phase);
    let fresh_1 = m.reg("fresh_1", bit, 0);
    m.set_next(fresh_1, fresh);
    let fresh_2 = m.reg("fresh_2", bit, 0);
    m.set_next(fresh_2, fresh_1);
    let phase_1 = m.data_reg("phase_1", phase.ty());
    m.set_next(phase_1, phase);
    let phase_2 = m.data_reg("phase_2", phase.ty());
    m.set_next(phase_2, phase_1);
    let sum = Ty::s(STEP + OFFSET + 1);
    let low = m.extend(product_reg, sum.width);
    let high = m.shl_const(low, HALF);
    let is_high = m.bit(phase_2, 0);
    let term = m.mux(is_high, high, low);
    let term = m.name(term, "term");
    let accumulate = |m: &mut ModuleBuilder, name: &str, first: u32, last: u32| {
        let register = m.data_reg(name, sum);
        let begins = is(m, phase_2, first);
        let none = m.lit(0, sum);
        let before = m.mux(begins, none, register);
        let next = m.add(before, term);
        let (from, to) = (m.lit(first, phase_2.ty()), m.lit(last, phase_2.ty()));
        let (above, below) = (m.ge(phase_2, from), m.le(phase_2, to));
        let here = if first == 0 {
            below
        } else {
            m.and(above, below)
        };
        let here = m.and(here, fresh_2);
        m.set_next_if(register, here, next);
        register
    };
    let p = accumulate(m, "p_sum", 0, 3);
    let q = accumulate(m, "q_sum", 4, PHASES - 1);
    let begins = is(m, phase, 0);
    let begins = m.and(held, begins);
    let begins = m.name(begins, "looks_up");
    let stored = table.look_up(m, begins, fields.opacity);

    m.section("Entry that settles");
    let keep = |m: &mut ModuleBuilder, name: &str, value: Signal| {
        let register = m.data_reg(name, value.ty());
        m.set_next_if(register, leaves, value);
        register
    };
    let slot = keep(m, "slot_2", first_slot);
    let factors = [0, 1, 2].map(|i| keep(m, ["l11", "l21", "l22"][i], fields.factor[i]));
    let opacity = keep(m, "opacity", fields.opacity);
    let colour = keep(m, "colour", fields.colour);
    let last = [0, 1].map(|i| keep(m, ["last_column", "last_row"][i], first_last[i]));
    let found = Limit::kept(m, w, stored, leaves);
    let limit_root = m.instance("limit_root", &root()?, &[("square", found.early)]);
    let always = m.lit(1, bit);
    m.connect(limit_root, "advance", always);
    let limit_root = m.out(limit_root, "root");
    let is_settled = is(m, settled, SETTLES);
    let is_settled = m.name(is_settled, "is_settled");
    // The sums are whole here, before those of the next entry begin.
    let are_whole = is(m, settled, SUMMED);
    let are_whole = m.name(are_whole, "sums_are_whole");
    let start = p_and_q(m, [p, q]);
    let first = m.extend(start.values[1], AT_ROW);
    let hold = |m: &mut ModuleBuilder, name: &str, value: Signal| {
        let register = m.data_reg(name, value.ty());
        m.set_next_if(register, are_whole, value);
        register
    };
    let values = [0, 1].map(|i| hold(m, ["p_first", "q_first"][i], start.values[i]));
    let is_far = hold(m, "is_too_far", start.is_far);
    let start = Start { values, is_far };
    let links = [
        ("advance", are_whole),
        ("start", first),
        ("step", factors[2]),
        ("root", limit_root),
    ];
    let rows = m.instance("rows_near", &near()?, &links);
    let rows = m.out(rows, "near");
    let are_found = is(m, settled, SEARCHED);
    let register = m.data_reg("rows_in_reach", rows.ty());
    m.set_next_if(register, are_found, rows);
    let rows = register;
    let in_tile = up_to(m, last[1]);
    let rows = m.all_of(&[rows, in_tile, alive]);
    let rows = m.name(rows, "rows_found");
    let some = m.any(rows);
    let is_near = m.not(start.is_far);
    let needed = m.all_of(&[some, found.counts, is_near]);
    let needed = m.name(needed, "is_needed");
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

    m.section("Outputs");
    m.output("ready", ready, "takes an entry at the clock edge");
    m.output("out_valid", offered, "an entry with rows");
    m.output("out_slot", slot, "");
    m.output("p_start", start.values[0], "at the tile's first pixel");
    m.output("q_start", start.values[1], "");
    for (name, factor) in ["out_l11", "out_l21", "out_l22"].into_iter().zip(factors) {
        m.output(name, factor, "");
    }
    m.output("out_opacity", opacity, "");
    m.output("out_colour", colour, "");
    m.output("out_last_x", last[0], "");
    m.output("out_limit", found.limit, "largest power that counts");
    m.output("out_search", found.search, "the same, for the search");
    m.output("out_rows", rows, "to be searched");
    let busy = m.or(held, settling);
    m.output("busy", busy, "holds an entry");
    builder.finish()
}

/// Offset of the first pixel's centre from the mean.
fn offset(m: &mut ModuleBuilder, tile: Signal, centred: Signal, mean: Signal) -> Signal {
    let fraction = MEAN.frac_bits() - 1;
    let (low, edge) = (m.lit(0, Ty::u(fraction)), m.lit(0, Ty::u(4)));
    let sign = m.lit(0, Ty::u(OFFSET - 16 - MEAN.frac_bits()));
    let corner = m.cat(&[sign, tile, edge, centred, low]);
    let corner = m.as_signed(corner);
    let mean = m.extend(mean, OFFSET);
    m.sub(corner, mean)
}

/// Start values.
struct Start {
    values: [Signal; 2],
    is_far: Signal,
}

/// Start values in their format, and whether one exceeds it.
fn p_and_q(m: &mut ModuleBuilder, sums: [Signal; 2]) -> Start {
    let bits = [START, START - 1];
    let mut far = vec![];
    let values = [0, 1].map(|i| {
        let sum = sums[i];
        let top = m.slice(sum, bits[i] - 1, sum.width() + 1 - bits[i]);
        let (any, all) = (m.any(top), m.all(top));
        far.push(m.xor(any, all));
        let low = m.slice(sum, 0, START);
        m.as_signed(low)
    });
    let is_far = m.or(far[0], far[1]);
    Start {
        values,
        is_far: m.name(is_far, "far"),
    }
}
