//! Pixels of spans, one a clock: square sum, and the cut.

use std::sync::Arc;

use potamoi_formats::config::SplatOpacity;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::entries::INDEX;
use super::formats::{AT_ROW, MAGNITUDE, STEP, Widths};
use super::forms::{form_at, magnitude};
use super::masks::lowest;
use super::near::PLACE;
use super::product::{product_of, times};
use super::registers::moved;

/// A row, and the signals that its pixels are computed from.
struct Row {
    row: Signal,
    /// It is the last one of its entry.
    last: Signal,
    /// Number of its entry.
    index: Signal,
    p: Signal,
    q: Signal,
    /// `q` is too large to count.
    beyond: Signal,
    l11: Signal,
}

/// Inputs of the module.
struct Inputs {
    valid: Signal,
    mask: Signal,
    row: Row,
    limit: Signal,
    info: Signal,
    ready: Signal,
}

impl Inputs {
    fn declare(m: &mut ModuleBuilder, w: &Widths) -> Self {
        let bit = Ty::bit();
        let valid = m.input("valid", bit, "a row");
        let mask = m.input("mask", Ty::u(16), "its pixels");
        let row = Row {
            row: m.input("row", Ty::u(4), ""),
            last: m.input("last", bit, "the last row of its entry"),
            index: m.input("index", Ty::u(INDEX), "number of its entry"),
            p: m.input("p", Ty::s(AT_ROW), "at the row's first pixel"),
            q: m.input("q", Ty::u(MAGNITUDE), "magnitude"),
            beyond: m.input("beyond", bit, "q is too large to count"),
            l11: m.input("l11", Ty::s(STEP), "step of p, of the entry `index`"),
        };
        Self {
            valid,
            mask,
            row,
            limit: m.input("limit", Ty::u(w.power), "of the entry `limit_index`"),
            info: m.input("entry_info", Ty::u(16 + 48 + w.slot), "likewise"),
            ready: m.input("out_ready", bit, "the power is taken"),
        }
    }
}

/// Builds `splat_pixels`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn pixels(w: &Widths) -> Result<Arc<Module>, IrErrors> {
    let mut builder = ModuleBuilder::new("splat_pixels");
    let m = &mut builder;
    m.doc("pixels of spans, one a clock: their power, and whether it may count.");
    let inputs = Inputs::declare(m, w);
    m.section("Row whose pixels are walked");
    let walk = walk(m, &inputs);
    let moves = walk.moves;
    m.section("p at the pixel");
    let forms = forms(m, &walk);
    m.section("Half the sum of the squares");
    let (tag, power) = power(m, w, forms, moves)?;
    m.section("Cut");
    let [out, info] = cut(m, w, &inputs, &walk, (tag, power));
    let release = m.and(tag.ends, moves);

    m.section("Outputs");
    m.output("next_row", walk.pop, "takes the row");
    m.output("limit_index", tag.index, "the entry whose limit is used");
    m.output("out_valid", walk.kept, "a power that may count");
    m.output("out_power", out, "");
    m.output("out_info", info, "of the pair");
    m.output("entry_done", release, "the oldest entry has no more pixels");
    let summed = m.and(tag.valid, moves);
    m.output("summed", summed, "a square sum is compared");
    builder.finish()
}

/// The walk over a row's pixels, one a clock.
struct Walk {
    /// A row is taken.
    pop: Signal,
    /// The stages move.
    moves: Signal,
    /// The register of whether the cut keeps a power.
    kept: Signal,
    row: Row,
    tag: Tag,
}

fn walk(m: &mut ModuleBuilder, inputs: &Inputs) -> Walk {
    let bit = Ty::bit();
    let walks = m.reg("walks", bit, 0);
    let left = m.data_reg("left", Ty::u(16));
    let (place, rest) = lowest(m, left);
    let place = m.name(place, "place");
    let rest = m.name(rest, "left_after");
    let more = m.any(rest);
    let no_more = m.not(more);
    let no_more = m.name(no_more, "is_last_pixel");
    let kept = m.reg("kept", bit, 0);
    let not_kept = m.not(kept);
    let moves = m.or(not_kept, inputs.ready);
    let moves = m.name(moves, "moves");
    let step = m.and(walks, moves);
    let step = m.name(step, "walks_on");
    let ends = m.and(step, no_more);
    let ends = m.name(ends, "ends_row");
    let rests = m.not(walks);
    let free = m.or(rests, ends);
    let pop = m.and(inputs.valid, free);
    let pop = m.name(pop, "takes_row");
    let not_ends = m.not(ends);
    let still = m.and(walks, not_ends);
    let next = m.or(pop, still);
    m.set_next(walks, next);
    let next = m.mux(pop, inputs.mask, rest);
    let changes = m.or(pop, step);
    m.set_next_if(left, changes, next);
    let mut own = |name: &str, value| moved(m, name, value, pop);
    let row = Row {
        row: own("walked_row", inputs.row.row),
        last: own("walked_last", inputs.row.last),
        index: own("walked_index", inputs.row.index),
        p: own("walked_p", inputs.row.p),
        q: own("walked_q", inputs.row.q),
        beyond: own("walked_beyond", inputs.row.beyond),
        l11: own("walked_l11", inputs.row.l11),
    };
    let some = m.any(left);
    let is_last = m.and(row.last, no_more);
    let pixel = m.cat(&[row.row, place]);
    let tag = Tag {
        valid: m.and(walks, some),
        ends: m.and(walks, is_last),
        index: row.index,
        pixel,
    };
    Walk {
        pop,
        moves,
        kept,
        row,
        tag,
    }
}

/// The magnitudes of the forms at a pixel, in stage 4.
struct Forms {
    tag: Tag,
    p: Signal,
    q: Signal,
    /// One of them is too large to count.
    beyond: Signal,
}

fn forms(m: &mut ModuleBuilder, walk: &Walk) -> Forms {
    let (row, moves) = (&walk.row, walk.moves);
    let mut tag = walk.tag.moved(m, 1, moves);
    let step = moved(m, "l11_1", row.l11, moves);
    let from = moved(m, "p_1", row.p, moves);
    let q = moved(m, "q_1", row.q, moves);
    let beyond = moved(m, "beyond_1", row.beyond, moves);
    let place = m.slice(tag.pixel, 0, PLACE);
    let grown = times(m, step, place, "l11_wide");
    tag = tag.moved(m, 2, moves);
    let grown = moved(m, "grown", grown, moves);
    let from = moved(m, "p_2", from, moves);
    let q = moved(m, "q_2", q, moves);
    let beyond = moved(m, "beyond_2", beyond, moves);
    let exact = form_at(m, [from, grown], AT_ROW + 1, "p_growth");
    tag = tag.moved(m, 3, moves);
    let exact = moved(m, "p_3", exact, moves);
    let q = moved(m, "q_3", q, moves);
    let beyond = moved(m, "beyond_3", beyond, moves);
    let (p, p_beyond) = magnitude(m, exact, "p_absolute");
    let beyond = m.or(beyond, p_beyond);
    Forms {
        tag: tag.moved(m, 4, moves),
        p: moved(m, "p_4", p, moves),
        q: moved(m, "q_4", q, moves),
        beyond: moved(m, "beyond_4", beyond, moves),
    }
}

/// Half the sum of the squares in stage 7, half up, saturating.
fn power(
    m: &mut ModuleBuilder,
    w: &Widths,
    forms: Forms,
    moves: Signal,
) -> Result<(Tag, Signal), IrErrors> {
    let Forms {
        mut tag,
        p,
        q,
        beyond,
    } = forms;
    let (p, q) = (
        product_of(m, "p_squared", (p, p), moves)?,
        product_of(m, "q_squared", (q, q), moves)?,
    );
    tag = tag.moved(m, 5, moves);
    let beyond = moved(m, "beyond_5", beyond, moves);
    tag = tag.moved(m, 6, moves);
    let p = moved(m, "p_square", p, moves);
    let q = moved(m, "q_square", q, moves);
    let beyond = moved(m, "beyond_6", beyond, moves);
    let shift = 33 - w.power_fraction;
    let wide = 2 * MAGNITUDE + 2;
    let (p, q) = (m.extend(p, wide), m.extend(q, wide));
    let half = m.lit(1u64 << (shift - 1), p.ty());
    let sum = m.add(p, q);
    let sum = m.add(sum, half);
    let sum = m.name(sum, "squares_and_half");
    let sum = m.slice(sum, shift, wide - shift);
    let sum = m.name(sum, "half_sum");
    let power = m.saturate(sum, Ty::u(w.power));
    let most = m.lit((1u64 << w.power) - 1, Ty::u(w.power));
    let power = m.mux(beyond, most, power);
    tag = tag.moved(m, 7, moves);
    Ok((tag, moved(m, "power_7", power, moves)))
}

/// What goes on of a power that the limit keeps: the exponential's operand, and what belongs to the pair.
fn cut(
    m: &mut ModuleBuilder,
    w: &Widths,
    inputs: &Inputs,
    walk: &Walk,
    (tag, power): (Tag, Signal),
) -> [Signal; 2] {
    let moves = walk.moves;
    let below = m.le(power, inputs.limit);
    let kept = m.and(tag.valid, below);
    m.set_next_if(walk.kept, moves, kept);
    let (out, info) = match w.opacity {
        SplatOpacity::Multiplied => (power, inputs.info),
        // Within the limit the sum is no larger than a power.
        SplatOpacity::InPower => {
            let other = inputs.info.width() - w.power;
            let opacity = m.slice(inputs.info, other, w.power);
            (m.add(power, opacity), m.slice(inputs.info, 0, other))
        }
    };
    let out = moved(m, "power", out, moves);
    let info = m.cat(&[info, tag.pixel]);
    [out, moved(m, "info", info, moves)]
}

/// What goes along with a pixel.
#[derive(Clone, Copy)]
struct Tag {
    valid: Signal,
    ends: Signal,
    index: Signal,
    pixel: Signal,
}

impl Tag {
    fn moved(self, m: &mut ModuleBuilder, stage: u32, enable: Signal) -> Self {
        let flag = |m: &mut ModuleBuilder, name: &str, value| {
            let register = m.reg(&format!("{name}_{stage}"), Ty::bit(), 0);
            m.set_next_if(register, enable, value);
            register
        };
        Self {
            valid: flag(m, "valid", self.valid),
            ends: flag(m, "ends", self.ends),
            index: moved(m, &format!("index_{stage}"), self.index, enable),
            pixel: moved(m, &format!("pixel_{stage}"), self.pixel, enable),
        }
    }
}
