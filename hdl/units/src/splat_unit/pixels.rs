//! Pixels of spans, one a clock: square sum, and the cut.

use std::sync::Arc;

use potamoi_formats::config::SplatOpacity;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::formats::{AT_ROW, MAGNITUDE, STEP, Widths};
use super::near::PLACE;
use super::product::{product_of, times};
use super::rows::{INDEX, form_at, lowest, magnitude, moved};

/// Builds `splat_pixels`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn pixels(w: &Widths) -> Result<Arc<Module>, IrErrors> {
    let mut builder = ModuleBuilder::new("splat_pixels");
    let m = &mut builder;
    m.doc("pixels of spans, one a clock: their power, and whether it may count.");
    let bit = Ty::bit();
    let valid = m.input("valid", bit, "a row");
    let mask = m.input("mask", Ty::u(16), "its pixels");
    let row = m.input("row", Ty::u(4), "");
    let last = m.input("last", bit, "the last row of its entry");
    let index = m.input("index", Ty::u(INDEX), "number of its entry");
    let p = m.input("p", Ty::s(AT_ROW), "at the row's first pixel");
    let q = m.input("q", Ty::u(MAGNITUDE), "magnitude");
    let beyond = m.input("beyond", bit, "q is too large to count");
    let l11 = m.input("l11", Ty::s(STEP), "step of p, of the entry `index`");
    let limit = m.input("limit", Ty::u(w.power), "of the entry `limit_index`");
    let info = m.input("entry_info", Ty::u(16 + 48 + w.slot), "likewise");
    let ready = m.input("out_ready", bit, "the power is taken");

    m.section("Row whose pixels are walked");
    let walks = m.reg("walks", bit, 0);
    let left = m.data_reg("left", Ty::u(16));
    let (place, rest) = lowest(m, left);
    let place = m.name(place, "place");
    let rest = m.name(rest, "left_after");
    let more = m.any(rest);
    let no_more = m.not(more);
    let kept_now = m.reg("kept", bit, 0);
    let not_kept = m.not(kept_now);
    let moves = m.or(not_kept, ready);
    let moves = m.name(moves, "moves");
    let step = m.and(walks, moves);
    let ends = m.and(step, no_more);
    let ends = m.name(ends, "ends_row");
    let rests = m.not(walks);
    let free = m.or(rests, ends);
    let pop = m.and(valid, free);
    let pop = m.name(pop, "takes_row");
    let not_ends = m.not(ends);
    let still = m.and(walks, not_ends);
    let next = m.or(pop, still);
    m.set_next(walks, next);
    let next = m.mux(pop, mask, rest);
    let changes = m.or(pop, step);
    m.set_next_if(left, changes, next);
    let own = |m: &mut ModuleBuilder, name: &str, value| moved(m, name, value, pop);
    let row = own(m, "walked_row", row);
    let last = own(m, "walked_last", last);
    let index = own(m, "walked_index", index);
    let p = own(m, "walked_p", p);
    let q = own(m, "walked_q", q);
    let beyond = own(m, "walked_beyond", beyond);
    let l11 = own(m, "walked_l11", l11);
    let some = m.any(left);
    let is_last = m.and(last, no_more);
    let pixel = m.cat(&[row, place]);
    let mut tag = Tag {
        valid: m.and(walks, some),
        ends: m.and(walks, is_last),
        index,
        pixel,
    };

    m.section("p at the pixel");
    tag = tag.moved(m, 1, moves);
    let step = moved(m, "l11_1", l11, moves);
    let from = moved(m, "p_1", p, moves);
    let q = moved(m, "q_1", q, moves);
    let beyond = moved(m, "beyond_1", beyond, moves);
    let place = m.slice(tag.pixel, 0, PLACE);
    let grown = times(m, step, place);
    tag = tag.moved(m, 2, moves);
    let grown = moved(m, "grown", grown, moves);
    let from = moved(m, "p_2", from, moves);
    let q = moved(m, "q_2", q, moves);
    let beyond = moved(m, "beyond_2", beyond, moves);
    let exact = form_at(m, from, grown, AT_ROW + 1);
    tag = tag.moved(m, 3, moves);
    let exact = moved(m, "p_3", exact, moves);
    let q = moved(m, "q_3", q, moves);
    let beyond = moved(m, "beyond_3", beyond, moves);
    let (p, p_beyond) = magnitude(m, exact);
    let beyond = m.or(beyond, p_beyond);
    tag = tag.moved(m, 4, moves);
    let p = moved(m, "p_4", p, moves);
    let q = moved(m, "q_4", q, moves);
    let beyond = moved(m, "beyond_4", beyond, moves);

    m.section("Half the sum of the squares");
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
    let sum = m.slice(sum, shift, wide - shift);
    let power = m.saturate(sum, Ty::u(w.power));
    let most = m.lit((1u64 << w.power) - 1, Ty::u(w.power));
    let power = m.mux(beyond, most, power);
    tag = tag.moved(m, 7, moves);
    let power = moved(m, "power_7", power, moves);

    m.section("Cut");
    let below = m.le(power, limit);
    let kept = m.and(tag.valid, below);
    m.set_next_if(kept_now, moves, kept);
    let (out, info) = match w.opacity {
        SplatOpacity::Multiplied => (power, info),
        // Within the limit the sum is no larger than a power.
        SplatOpacity::InPower => {
            let other = info.width() - w.power;
            let opacity = m.slice(info, other, w.power);
            (m.add(power, opacity), m.slice(info, 0, other))
        }
    };
    let out = moved(m, "power", out, moves);
    let info = m.cat(&[info, tag.pixel]);
    let info = moved(m, "info", info, moves);
    let release = m.and(tag.ends, moves);

    m.section("Outputs");
    m.output("next_row", pop, "takes the row");
    m.output("limit_index", tag.index, "the entry whose limit is used");
    m.output("out_valid", kept_now, "a power that may count");
    m.output("out_power", out, "");
    m.output("out_info", info, "of the pair");
    m.output("entry_done", release, "the oldest entry has no more pixels");
    let summed = m.and(tag.valid, moves);
    m.output("summed", summed, "a square sum is compared");
    builder.finish()
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
