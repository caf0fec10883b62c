//! Rows of an entry: the forms at a row, and the pixels of its span.

use std::sync::Arc;

use potamoi_formats::record::MEAN;
use potamoi_netlist::{IrErrors, MemId, Module, ModuleBuilder, Signal, Ty};

use super::formats::{
    AT_ROW, COMPARE, ENTRIES, EXACT, MAGNITUDE, ROOT, SEARCH_LIMIT, START, STEP, Widths,
};
use super::near::{near, up_to};
use super::product::times;
use super::root::{CLOCKS, root};
use crate::circuits::{bits_for, is, plus_one};

/// Bits of an entry's number while its pixels are in flight.
pub(super) const INDEX: u32 = ENTRIES.ilog2();

/// The stage in which a row's root is there: five to the square of `q`, the rest, and the root.
const ROOTED: u32 = 6 + CLOCKS;
/// The stage of the form and its bounds, in which the row's live pixels are read.
const FORMED: u32 = ROOTED + 1;
/// The stage in which the entry is read: its step, and that step at each place, are two more.
const ENTRY_READ: u32 = FORMED - 3;
/// The stage in which a row is pushed.
const PUSHED: u32 = FORMED + 1;

/// The lowest set bit of a mask of 16: its place, and the mask without it.
pub(super) fn lowest(m: &mut ModuleBuilder, mask: Signal) -> (Signal, Signal) {
    let mut place = m.lit(15, Ty::u(4));
    for bit in (0..15).rev() {
        let set = m.bit(mask, bit);
        let own = m.lit(bit, Ty::u(4));
        place = m.mux(set, own, place);
    }
    let one = m.lit(1, mask.ty());
    let less = m.sub(mask, one);
    let rest = m.and(mask, less);
    (place, rest)
}

/// What a form rounded half to even counts with: its magnitude, and whether it is too large to count. One
/// carry does both: the magnitude of a negative form is the complement of its floor, and one more where
/// that floor is not rounded up.
pub(super) fn magnitude(m: &mut ModuleBuilder, exact: Signal) -> (Signal, Signal) {
    let dropped = EXACT - 16;
    let floor = m.slice(exact, dropped, exact.width() - dropped);
    let [odd, guard] = [dropped, dropped - 1].map(|place| m.bit(exact, place));
    let below = m.slice(exact, 0, dropped - 1);
    let below = m.any(below);
    let to_even = m.or(below, odd);
    let up = m.and(guard, to_even);
    let negative = m.bit(exact, exact.width() - 1);
    let flips = m.repeat(negative, floor.width());
    let flipped = m.xor(floor, flips);
    let carry = m.xor(up, negative);
    let carry = m.extend(carry, floor.width());
    let absolute = m.add(flipped, carry);
    let high = m.slice(absolute, MAGNITUDE, absolute.width() - MAGNITUDE);
    let beyond = m.any(high);
    (m.slice(absolute, 0, MAGNITUDE), beyond)
}

/// A form where it has grown since its start value.
pub(super) fn form_at(m: &mut ModuleBuilder, start: Signal, grown: Signal, width: u32) -> Signal {
    let fraction = m.lit(0, Ty::u(MEAN.frac_bits()));
    let grown = m.as_unsigned(grown);
    let grown = m.cat(&[grown, fraction]);
    let grown = m.as_signed(grown);
    let (start, grown) = (m.extend(start, width), m.extend(grown, width));
    m.add(start, grown)
}

/// A register that moves with the pipeline.
pub(super) fn moved(m: &mut ModuleBuilder, name: &str, value: Signal, enable: Signal) -> Signal {
    let register = m.data_reg(name, value.ty());
    m.set_next_if(register, enable, value);
    register
}

/// The same over several stages, as one shift register; the first stage is lowest.
fn shifted(
    m: &mut ModuleBuilder,
    name: &str,
    value: Signal,
    stages: u32,
    enable: Signal,
) -> Signal {
    if stages == 0 {
        return value;
    }
    let width = value.width();
    let all = m.data_reg(name, Ty::u(stages * width));
    let value = m.as_unsigned(value);
    let next = match stages {
        1 => value,
        _ => {
            let held = m.slice(all, 0, (stages - 1) * width);
            m.cat(&[held, value])
        }
    };
    m.set_next_if(all, enable, next);
    m.slice(all, (stages - 1) * width, width)
}

/// What an entry's pixels need, by its number.
struct Entries {
    memory: MemId,
    /// Widths of the fields, the lowest first.
    widths: Vec<u32>,
}

/// Fields of a stored entry.
pub(super) struct Entry {
    pub(super) l11: Signal,
    pub(super) last_x: Signal,
    pub(super) slot: Signal,
    pub(super) limit: Signal,
    pub(super) opacity: Signal,
    pub(super) colour: Signal,
}

impl Entries {
    fn declare(m: &mut ModuleBuilder, w: &Widths) -> Self {
        let widths = vec![STEP, 4, w.slot, w.power, 16, 48];
        let all = widths.iter().sum();
        let memory = m.memory("entries", ENTRIES, all, "entries with pixels in flight");
        Self { memory, widths }
    }

    fn read(&self, m: &mut ModuleBuilder, index: Signal) -> Entry {
        let word = m.mem_read_async(self.memory, index);
        let mut at = 0;
        let mut next = |m: &mut ModuleBuilder, width: u32| {
            at += width;
            m.slice(word, at - width, width)
        };
        let fields: Vec<Signal> = self.widths.iter().map(|w| next(m, *w)).collect();
        Entry {
            l11: m.as_signed(fields[0]),
            last_x: fields[1],
            slot: fields[2],
            limit: fields[3],
            opacity: fields[4],
            colour: fields[5],
        }
    }
}

/// Builds `splat_rows`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn rows(w: &Widths) -> Result<Arc<Module>, IrErrors> {
    let mut builder = ModuleBuilder::new("splat_rows");
    let m = &mut builder;
    m.doc("rows of an entry, one a clock: forms at the row, and the pixels that may count.");
    let bit = Ty::bit();
    let valid = m.input("valid", bit, "an entry");
    let start =
        ["p_start", "q_start"].map(|name| m.input(name, Ty::s(START), "at the first pixel"));
    let factors = ["l11", "l21", "l22"].map(|name| m.input(name, Ty::s(STEP), ""));
    let rows = m.input("rows", Ty::u(16), "to be searched, one or more");
    let search = m.input("search", Ty::u(SEARCH_LIMIT), "limit of the entry");
    let limit = m.input("limit", Ty::u(w.power), "the same as a power");
    let [slot, last_x] = [("slot", w.slot), ("last_x", 4)].map(|(n, b)| m.input(n, Ty::u(b), ""));
    let [opacity, colour] =
        [("opacity", 16), ("colour", 48)].map(|(n, b)| m.input(n, Ty::u(b), ""));
    let room = m.input("room", bit, "the pipeline moves");
    let live = m.input(
        "live",
        Ty::u(16),
        "live pixels of the row that was asked for",
    );
    let release = m.input("entry_done", bit, "the oldest entry has no more pixels");
    let indices =
        ["pixel_index", "limit_index"].map(|n| m.input(n, Ty::u(INDEX), "number of an entry"));

    m.section("Entries in flight");
    let entries = Entries::declare(m, w);
    let busy = m.reg("busy", bit, 0);
    let left = m.data_reg("rows_left", Ty::u(16));
    let (row, rest) = lowest(m, left);
    let rest = m.name(rest, "rows_after");
    let row = m.name(row, "row");
    let last = m.any(rest);
    let last = m.not(last);
    let last = m.name(last, "last_row");
    let ends = m.all_of(&[busy, last, room]);
    let ends = m.name(ends, "ends");
    let used = m.reg("entries_used", Ty::u(bits_for(ENTRIES)), 0);
    let full = is(m, used, ENTRIES);
    let not_full = m.not(full);
    let not_busy = m.not(busy);
    let free = m.or(not_busy, ends);
    let ready = m.and(free, not_full);
    let ready = m.name(ready, "is_ready");
    let take = m.and(valid, ready);
    let take = m.name(take, "take");
    let index = m.reg("index", Ty::u(INDEX), 0);
    let next = plus_one(m, index);
    m.set_next_if(index, take, next);
    let own = moved(m, "own_index", index, take);
    let one = m.lit(1, used.ty());
    let (more, less) = (m.add(used, one), m.sub(used, one));
    let next = m.mux(take, more, less);
    let changes = m.xor(take, release);
    m.set_next_if(used, changes, next);
    let l11 = m.as_unsigned(factors[0]);
    let word = m.cat(&[colour, opacity, limit, slot, last_x, l11]);
    m.mem_write(entries.memory, take, index, word);
    let not_ends = m.not(ends);
    let still = m.and(busy, not_ends);
    let next = m.or(take, still);
    m.set_next(busy, next);
    let step = m.and(busy, room);
    let changes = m.or(take, step);
    let next = m.mux(take, rows, rest);
    m.set_next_if(left, changes, next);
    let start = [0, 1].map(|i| moved(m, ["p_held", "q_held"][i], start[i], take));
    let steps = [1, 2].map(|i| moved(m, ["l21_held", "l22_held"][i - 1], factors[i], take));
    let search = moved(m, "search_held", search, take);

    m.section("Forms at the row");
    let mut tag = Tag {
        stage: 0,
        valid: busy,
        last,
        index: own,
        row,
    };
    tag = tag.moved(m, room);
    let start = [0, 1].map(|i| moved(m, ["p_held_1", "q_held_1"][i], start[i], room));
    let steps = [0, 1].map(|i| moved(m, ["l21_1", "l22_1"][i], steps[i], room));
    let search = moved(m, "search_1", search, room);
    let grown = steps.map(|step| times(m, step, tag.row));
    tag = tag.moved(m, room);
    let start = [0, 1].map(|i| moved(m, ["p_held_2", "q_held_2"][i], start[i], room));
    let grown = [0, 1].map(|i| moved(m, ["p_grown", "q_grown"][i], grown[i], room));
    let search = moved(m, "search_2", search, room);
    let forms = [0, 1].map(|i| form_at(m, start[i], grown[i], AT_ROW));
    tag = tag.moved(m, room);
    let forms = [0, 1].map(|i| moved(m, ["p_3", "q_3"][i], forms[i], room));
    let search = moved(m, "search_3", search, room);
    m.section("Magnitude of q");
    let (q, beyond) = magnitude(m, forms[1]);
    tag = tag.moved(m, room);
    let p = moved(m, "p_4", forms[0], room);
    let q = moved(m, "q_4", q, room);
    let beyond = moved(m, "beyond_4", beyond, room);
    let search = moved(m, "search_4", search, room);
    m.section("Root of what q leaves of the limit");
    let short = m.slice(q, 16 - COMPARE, ROOT);
    let square = times(m, short, short);
    tag = tag.moved(m, room);
    let square = moved(m, "q_square", square, room);
    let search = moved(m, "search_5", search, room);
    let beyond = moved(m, "beyond_5", beyond, room);
    let over = m.gt(square, search);
    let no_pixel = m.or(over, beyond);
    let rest = m.sub(search, square);
    let rest = moved(m, "square_6", rest, room);
    let links = [("advance", room), ("square", rest)];
    let span_root = m.instance("span_root", &root()?, &links);
    let span_root = m.out(span_root, "root");
    m.section("Pixels of the span, and the row's live pixels");
    // A clock each: the entry, its step at the places, the form, its bounds, and the span.
    let tag = tag.until(m, ENTRY_READ, room);
    let entry = entries.read(m, tag.index);
    let tag = tag.until(m, FORMED, room);
    let step = moved(m, "step", entry.l11, room);
    let p = shifted(m, "p_stages", p, FORMED - 1 - 4, room);
    let start = m.as_signed(p);
    let links = [
        ("takes_step", room),
        ("takes_start", room),
        ("takes_root", room),
        ("start", start),
        ("step", step),
        ("root", span_root),
    ];
    let near = m.instance("span", &near()?, &links);
    let near = m.out(near, "near");
    let last_x = shifted(m, "last_columns", entry.last_x, 2, room);
    let columns = up_to(m, last_x);
    let columns = moved(m, "columns", columns, room);
    let no_pixel = shifted(m, "no_pixel", no_pixel, FORMED - 5, room);
    let some = m.not(no_pixel);
    let some = m.repeat(some, 16);
    let span = m.all_of(&[near, columns, some]);
    let span = moved(m, "reach", span, room);
    let slot = shifted(m, "span_slot", entry.slot, FORMED - ENTRY_READ, room);
    let address = m.cat(&[slot, tag.row]);
    let live = moved(m, "live_in_row", live, room);
    let tag = tag.until(m, PUSHED, room);
    let p = shifted(m, "p_span", p, 2, room);
    let p = m.as_signed(p);
    let q = shifted(m, "q_stages", q, PUSHED - 4, room);
    let beyond = shifted(m, "beyond_stages", beyond, PUSHED - 5, room);
    let mask = m.and(span, live);
    let mask = m.name(mask, "mask");
    let some = m.any(mask);
    let wanted = m.or(some, tag.last);
    let push = m.all_of(&[tag.valid, wanted, room]);

    m.section("Outputs");
    m.output("ready", ready, "takes an entry at the clock edge");
    m.output("push", push, "a row with pixels, or the last of an entry");
    m.output("out_mask", mask, "");
    m.output("out_row", tag.row, "");
    m.output("out_last", tag.last, "the last row of its entry");
    m.output("out_index", tag.index, "number of the entry");
    m.output("out_p", p, "at the row's first pixel");
    m.output("out_q", q, "magnitude");
    m.output("out_beyond", beyond, "q is too large to count");
    m.output("live_addr", address, "the row whose live pixels are read");
    let pixel = entries.read(m, indices[0]);
    m.output("pixel_l11", pixel.l11, "of the entry asked for");
    let limited = entries.read(m, indices[1]);
    m.output("entry_limit", limited.limit, "of the entry asked for");
    let info = m.cat(&[limited.opacity, limited.colour, limited.slot]);
    m.output("entry_info", info, "opacity, colour and slot");
    let flying = m.any(used);
    m.output("in_flight", flying, "an entry is in flight");
    builder.finish()
}

/// What goes along with a row.
#[derive(Clone, Copy)]
struct Tag {
    stage: u32,
    valid: Signal,
    last: Signal,
    index: Signal,
    row: Signal,
}

impl Tag {
    /// In the next stage.
    fn moved(self, m: &mut ModuleBuilder, enable: Signal) -> Self {
        let stage = self.stage + 1;
        let valid = m.reg(&format!("valid_{stage}"), Ty::bit(), 0);
        m.set_next_if(valid, enable, self.valid);
        let mut one = |name: &str, value| moved(m, &format!("{name}_{stage}"), value, enable);
        Self {
            stage,
            valid,
            last: one("last", self.last),
            index: one("index", self.index),
            row: one("row", self.row),
        }
    }

    /// In a later stage.
    fn until(self, m: &mut ModuleBuilder, stage: u32, enable: Signal) -> Self {
        (self.stage..stage).fold(self, |tag, _| tag.moved(m, enable))
    }
}

#[cfg(test)]
mod rounding {
    #![allow(clippy::unwrap_used)]
    use potamoi_formats::fixed::{Rounding, round_shift};
    use potamoi_netlist::Interpreter;

    use super::*;

    /// Forms at ties, next to them and at their largest, of both signs: the magnitude is that of the form
    /// rounded half to even, and what does not fit is beyond.
    #[test]
    fn magnitudes_are_those_of_forms_rounded_half_to_even() {
        let mut m = ModuleBuilder::new("form");
        let exact = m.input("exact", Ty::s(AT_ROW), "");
        let (found, beyond) = magnitude(&mut m, exact);
        m.output("magnitude", found, "");
        m.output("beyond", beyond, "");
        let module = m.finish().unwrap();
        let mut run = Interpreter::new(&module, 1);
        let [exact, found, beyond] =
            ["exact", "magnitude", "beyond"].map(|name| run.port(name).unwrap());
        let dropped = EXACT - 16;
        let (tie, most) = (1i64 << (dropped - 1), (1i64 << (AT_ROW - 1)) - 1);
        let wholes = [0, 1, 2, 5, (1 << MAGNITUDE) - 1, 1 << MAGNITUDE, 1 << 23];
        let near = [-1, 0, 1].map(|off| tie + off);
        let forms = wholes
            .iter()
            .flat_map(|whole| near.map(|part| (*whole << dropped) + part))
            .chain(wholes.map(|whole| whole << dropped))
            .chain([most, most - tie])
            .filter(|form| *form <= most);
        for form in forms.flat_map(|form| [form, -form]).chain([-most - 1]) {
            run.set_u64(exact, form as u64 & ((1 << AT_ROW) - 1))
                .unwrap();
            run.eval().unwrap();
            let rounded = round_shift(form.into(), dropped, Rounding::HalfEven).unsigned_abs();
            let fits = rounded < 1 << MAGNITUDE;
            assert_eq!(run.get_u64(beyond).unwrap(), u64::from(!fits), "{form}");
            if fits {
                assert_eq!(u128::from(run.get_u64(found).unwrap()), rounded, "{form}");
            }
        }
    }
}
