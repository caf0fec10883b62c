//! Rows of an entry: the forms at a row, and the pixels of its span.

use std::sync::Arc;

use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::entries::{Entries, INDEX};
use super::formats::{AT_ROW, COMPARE, ENTRIES, ROOT, SEARCH_LIMIT, START, STEP, Widths};
use super::forms::{form_at, magnitude};
use super::masks::{lowest, up_to};
use super::near::near;
use super::product::times;
use super::registers::{moved, shifted};
use super::root::{CLOCKS, root};
use super::row_tag::RowTag;
use crate::circuits::{bits_for, is, plus_one};

/// The stage of the magnitude of `q`.
const MEASURED: u32 = 4;
/// The stage of its square.
const SQUARED: u32 = MEASURED + 1;
/// The stage in which a row's root is there: the rest of the limit, and the root.
const ROOTED: u32 = SQUARED + 1 + CLOCKS;
/// The stage of the form and its bounds, in which the row's live pixels are read.
const FORMED: u32 = ROOTED + 1;
/// The stage in which the entry is read: its step, and that step at each place, are two more.
const ENTRY_READ: u32 = FORMED - 3;
/// The stage in which a row is pushed.
const PUSHED: u32 = FORMED + 1;

/// Inputs of the module.
struct Inputs {
    valid: Signal,
    start: [Signal; 2],
    factors: [Signal; 3],
    rows: Signal,
    search: Signal,
    limit: Signal,
    slot: Signal,
    last_x: Signal,
    opacity: Signal,
    colour: Signal,
    room: Signal,
    live: Signal,
    release: Signal,
    /// Of the entries whose step, and whose limit, are asked for.
    indices: [Signal; 2],
}

impl Inputs {
    fn declare(m: &mut ModuleBuilder, w: &Widths) -> Self {
        let bit = Ty::bit();
        let valid = m.input("valid", bit, "an entry");
        let start =
            ["p_start", "q_start"].map(|name| m.input(name, Ty::s(START), "at the first pixel"));
        let factors = ["l11", "l21", "l22"].map(|name| m.input(name, Ty::s(STEP), ""));
        let rows = m.input("rows", Ty::u(16), "to be searched, one or more");
        let search = m.input("search", Ty::u(SEARCH_LIMIT), "limit of the entry");
        let limit = m.input("limit", Ty::u(w.power), "the same as a power");
        let [slot, last_x] =
            [("slot", w.slot), ("last_x", 4)].map(|(n, b)| m.input(n, Ty::u(b), ""));
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
        Self {
            valid,
            start,
            factors,
            rows,
            search,
            limit,
            slot,
            last_x,
            opacity,
            colour,
            room,
            live,
            release,
            indices,
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
    let inputs = Inputs::declare(m, w);
    m.section("Entries in flight");
    let entries = Entries::declare(m, w);
    let searched = searched(m, &inputs, &entries);
    let (ready, used) = (searched.ready, searched.used);
    m.section("Forms at the row");
    let at_row = at_row(m, searched, inputs.room);
    m.section("Magnitude of q");
    let measured = measured(m, &at_row, inputs.room);
    m.section("Root of what q leaves of the limit");
    let rooted = rooted(m, &measured, inputs.room)?;
    m.section("Pixels of the span, and the row's live pixels");
    let found = span(m, &inputs, &entries, &rooted)?;

    m.section("Outputs");
    m.output("ready", ready, "takes an entry at the clock edge");
    found.output(m);
    let pixel = entries.read(m, inputs.indices[0], "walked_entry");
    m.output("pixel_l11", pixel.l11, "of the entry asked for");
    let limited = entries.read(m, inputs.indices[1], "limited_entry");
    m.output("entry_limit", limited.limit, "of the entry asked for");
    let info = m.cat(&[limited.opacity, limited.colour, limited.slot]);
    m.output("entry_info", info, "opacity, colour and slot");
    let flying = m.any(used);
    m.output("in_flight", flying, "an entry is in flight");
    builder.finish()
}

/// The entry whose rows are searched, one a clock.
struct Searched {
    ready: Signal,
    /// Number of entries in flight.
    used: Signal,
    tag: RowTag,
    start: [Signal; 2],
    /// Of `p` and `q` from row to row.
    steps: [Signal; 2],
    search: Signal,
}

/// Takes an entry, stores what its pixels need, and walks its rows.
fn searched(m: &mut ModuleBuilder, inputs: &Inputs, entries: &Entries) -> Searched {
    let (room, factors) = (inputs.room, inputs.factors);
    let busy = m.reg("busy", Ty::bit(), 0);
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
    let take = m.and(inputs.valid, ready);
    let take = m.name(take, "take");
    let index = m.reg("index", Ty::u(INDEX), 0);
    let next = plus_one(m, index);
    m.set_next_if(index, take, next);
    let own = moved(m, "own_index", index, take);
    let one = m.lit(1, used.ty());
    let (more, less) = (m.add(used, one), m.sub(used, one));
    let next = m.mux(take, more, less);
    let changes = m.xor(take, inputs.release);
    m.set_next_if(used, changes, next);
    let l11 = m.as_unsigned(factors[0]);
    let fields = [
        inputs.colour,
        inputs.opacity,
        inputs.limit,
        inputs.slot,
        inputs.last_x,
        l11,
    ];
    let word = m.cat(&fields);
    entries.write(m, take, index, word);
    let not_ends = m.not(ends);
    let still = m.and(busy, not_ends);
    let next = m.or(take, still);
    m.set_next(busy, next);
    let step = m.and(busy, room);
    let changes = m.or(take, step);
    let next = m.mux(take, inputs.rows, rest);
    m.set_next_if(left, changes, next);
    let start = [0, 1].map(|i| moved(m, ["p_held", "q_held"][i], inputs.start[i], take));
    let steps = [1, 2].map(|i| moved(m, ["l21_held", "l22_held"][i - 1], factors[i], take));
    let search = moved(m, "search_held", inputs.search, take);
    let tag = RowTag {
        stage: 0,
        valid: busy,
        last,
        index: own,
        row,
    };
    Searched {
        ready,
        used,
        tag,
        start,
        steps,
        search,
    }
}

/// The forms at the first pixel of a row, exact.
struct AtRow {
    tag: RowTag,
    forms: [Signal; 2],
    search: Signal,
}

fn at_row(m: &mut ModuleBuilder, searched: Searched, room: Signal) -> AtRow {
    let Searched {
        mut tag,
        start,
        steps,
        search,
        ..
    } = searched;
    tag = tag.moved(m, room);
    let start = [0, 1].map(|i| moved(m, ["p_held_1", "q_held_1"][i], start[i], room));
    let steps = [0, 1].map(|i| moved(m, ["l21_1", "l22_1"][i], steps[i], room));
    let search = moved(m, "search_1", search, room);
    let grown = [0, 1].map(|i| times(m, steps[i], tag.row, ["l21_wide", "l22_wide"][i]));
    tag = tag.moved(m, room);
    let start = [0, 1].map(|i| moved(m, ["p_held_2", "q_held_2"][i], start[i], room));
    let grown = [0, 1].map(|i| moved(m, ["p_grown", "q_grown"][i], grown[i], room));
    let search = moved(m, "search_2", search, room);
    let forms = [0, 1].map(|i| {
        let name = ["p_growth", "q_growth"][i];
        form_at(m, [start[i], grown[i]], AT_ROW, name)
    });
    tag = tag.moved(m, room);
    let forms = [0, 1].map(|i| moved(m, ["p_3", "q_3"][i], forms[i], room));
    let search = moved(m, "search_3", search, room);
    AtRow { tag, forms, search }
}

/// The same, with the magnitude of `q`.
struct Measured {
    tag: RowTag,
    p: Signal,
    q: Signal,
    /// `q` is too large to count.
    beyond: Signal,
    search: Signal,
}

fn measured(m: &mut ModuleBuilder, at_row: &AtRow, room: Signal) -> Measured {
    let [p, q] = at_row.forms;
    let (q, beyond) = magnitude(m, q, "q_absolute");
    Measured {
        tag: at_row.tag.moved(m, room),
        p: moved(m, "p_4", p, room),
        q: moved(m, "q_4", q, room),
        beyond: moved(m, "beyond_4", beyond, room),
        search: moved(m, "search_4", at_row.search, room),
    }
}

/// The same, with the root of what `q` leaves of the limit.
struct Rooted {
    tag: RowTag,
    /// In stage [`MEASURED`].
    p: Signal,
    /// In stage [`MEASURED`].
    q: Signal,
    /// In stage [`SQUARED`].
    beyond: Signal,
    /// In stage [`SQUARED`]: nothing is left.
    no_pixel: Signal,
    /// In stage [`ROOTED`].
    root: Signal,
}

fn rooted(m: &mut ModuleBuilder, own: &Measured, room: Signal) -> Result<Rooted, IrErrors> {
    let short = m.slice(own.q, 16 - COMPARE, ROOT);
    let short = m.name(short, "q_short");
    let square = times(m, short, short, "q_short_wide");
    let tag = own.tag.moved(m, room);
    let square = moved(m, "q_square", square, room);
    let search = moved(m, "search_5", own.search, room);
    let beyond = moved(m, "beyond_5", own.beyond, room);
    let over = m.gt(square, search);
    let no_pixel = m.or(over, beyond);
    let rest = m.sub(search, square);
    let rest = moved(m, "square_6", rest, room);
    let links = [("advance", room), ("square", rest)];
    let span_root = m.instance("span_root", &root()?, &links);
    Ok(Rooted {
        tag,
        p: own.p,
        q: own.q,
        beyond,
        no_pixel,
        root: m.out(span_root, "root"),
    })
}

/// A row with the pixels that are left.
struct Found {
    push: Signal,
    mask: Signal,
    tag: RowTag,
    p: Signal,
    q: Signal,
    beyond: Signal,
    /// The row whose live pixels are read.
    address: Signal,
}

impl Found {
    fn output(&self, m: &mut ModuleBuilder) {
        m.output(
            "push",
            self.push,
            "a row with pixels, or the last of an entry",
        );
        m.output("out_mask", self.mask, "");
        m.output("out_row", self.tag.row, "");
        m.output("out_last", self.tag.last, "the last row of its entry");
        m.output("out_index", self.tag.index, "number of the entry");
        m.output("out_p", self.p, "at the row's first pixel");
        m.output("out_q", self.q, "magnitude");
        m.output("out_beyond", self.beyond, "q is too large to count");
        m.output(
            "live_addr",
            self.address,
            "the row whose live pixels are read",
        );
    }
}

/// A clock each: the entry, its step at the places, the form, its bounds, and the span.
fn span(
    m: &mut ModuleBuilder,
    inputs: &Inputs,
    entries: &Entries,
    own: &Rooted,
) -> Result<Found, IrErrors> {
    let room = inputs.room;
    let tag = own.tag.until(m, ENTRY_READ, room);
    let entry = entries.read(m, tag.index, "span_entry");
    let tag = tag.until(m, FORMED, room);
    let step = moved(m, "step", entry.l11, room);
    let p = shifted(m, "p_stages", own.p, FORMED - 1 - MEASURED, room);
    let start = m.as_signed(p);
    let links = [
        ("takes_step", room),
        ("takes_start", room),
        ("takes_root", room),
        ("start", start),
        ("step", step),
        ("root", own.root),
    ];
    let near = m.instance("span", &near()?, &links);
    let near = m.out(near, "near");
    let last_x = shifted(m, "last_columns", entry.last_x, 2, room);
    let columns = up_to(m, last_x);
    let columns = moved(m, "columns", columns, room);
    let no_pixel = shifted(m, "no_pixel", own.no_pixel, FORMED - SQUARED, room);
    let some = m.not(no_pixel);
    let some = m.repeat(some, 16);
    let span = m.all_of(&[near, columns, some]);
    let span = moved(m, "reach", span, room);
    let slot = shifted(m, "span_slot", entry.slot, FORMED - ENTRY_READ, room);
    let address = m.cat(&[slot, tag.row]);
    let live = moved(m, "live_in_row", inputs.live, room);
    let tag = tag.until(m, PUSHED, room);
    let p = shifted(m, "p_span", p, 2, room);
    let p = m.as_signed(p);
    let q = shifted(m, "q_stages", own.q, PUSHED - MEASURED, room);
    let beyond = shifted(m, "beyond_stages", own.beyond, PUSHED - SQUARED, room);
    let mask = m.and(span, live);
    let mask = m.name(mask, "mask");
    let some = m.any(mask);
    let wanted = m.or(some, tag.last);
    Ok(Found {
        push: m.all_of(&[tag.valid, wanted, room]),
        mask,
        tag,
        p,
        q,
        beyond,
        address,
    })
}
