//! The places of a row, or the rows of a tile, at which a form is near enough.

use std::sync::Arc;

use potamoi_formats::record::FACTOR;
use potamoi_netlist::{Feed, IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::formats::{AT_ROW, COMPARE, EXACT, ROOT, SEARCH, STEP};

/// Pixels of a row, rows of a tile.
pub(super) const SIDE: u32 = 16;
/// Bits of a place.
pub(super) const PLACE: u32 = SIDE.ilog2();
/// Bits of a start value in the search.
const START: u32 = AT_ROW - EXACT + SEARCH;
/// Bits of a step in the search.
const COARSE_STEP: u32 = STEP - FACTOR.frac_bits() + SEARCH;
/// Bits of a bound: a root, or what is less than its opposite, with a sign.
const BOUND: u32 = ROOT + 2;
/// Units below the opposite of the root that count as near: what cutting off may add.
const SLACK: u32 = 2;

/// A step times a place, 0 to 15.
pub(super) fn times(m: &mut ModuleBuilder, step: Signal, place: Signal) -> Signal {
    let wide = m.extend(step, step.width() + PLACE);
    let none = m.lit(0, wide.ty());
    let terms: Vec<Signal> = (0..PLACE)
        .map(|bit| {
            let set = m.bit(place, bit);
            let moved = m.shl_const(wide, bit);
            m.mux(set, moved, none)
        })
        .collect();
    crate::circuits::tree_sum(m, &terms)
}

/// Places 0 up to one, as a mask.
pub(super) fn up_to(m: &mut ModuleBuilder, last: Signal) -> Signal {
    let all = m.lit(u16::MAX, Ty::u(SIDE));
    let above = m.not(last);
    m.shr(all, above)
}

/// Builds `splat_place`: whether a form is near enough at one place.
fn place() -> Result<Arc<Module>, IrErrors> {
    let mut builder = ModuleBuilder::new("splat_place");
    let m = &mut builder;
    m.doc("whether a form is near enough at a place: of the form of the clock before.");
    let advance = m.input("advance", Ty::bit(), "takes over start and step");
    let start = m.input("start", Ty::s(START), "the form at place 0");
    let step = m.input("step", Ty::s(COARSE_STEP), "what it grows by a place");
    let place = m.input("place", Ty::u(PLACE), "");
    let bounds = ["lowest", "highest"].map(|name| m.input(name, Ty::s(BOUND), ""));
    let width = START + 1;
    let grown = times(m, step, place);
    let grown = m.name(grown, "grown");
    let (grown, start) = (m.extend(grown, width), m.extend(start, width));
    let at = m.add(start, grown);
    let at = m.name(at, "form_at_place");
    let dropped = SEARCH - COMPARE;
    let at = m.slice(at, dropped, width - dropped);
    let at = m.as_signed(at);
    let register = m.data_reg("form", at.ty());
    m.set_next_if(register, advance, at);
    let at = register;
    let [lowest, highest] = bounds.map(|bound| m.extend(bound, at.width()));
    let (above, below) = (m.ge(at, lowest), m.le(at, highest));
    let near = m.and(above, below);
    m.output("near", near, "");
    builder.finish()
}

/// Builds `splat_near`: the places 0 to 15 at which a form lies between the root, and its opposite less
/// the slack. Start and step are those of the clock before, the root is that of this one.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn near() -> Result<Arc<Module>, IrErrors> {
    let mut builder = ModuleBuilder::new("splat_near");
    let m = &mut builder;
    m.doc("the places at which a form is near enough.");
    let advance = m.input("advance", Ty::bit(), "takes over start and step");
    let start = m.input("start", Ty::s(AT_ROW), "the exact form at place 0");
    let step = m.input("step", Ty::s(STEP), "what it grows by a place");
    let root = m.input("root", Ty::u(ROOT), "the largest that is near");
    let start = m.slice(start, EXACT - SEARCH, START);
    let start = m.as_signed(start);
    let step = m.slice(step, STEP - COARSE_STEP, COARSE_STEP);
    let step = m.as_signed(step);
    let highest = m.extend(root, BOUND);
    let slack = m.lit(SLACK, highest.ty());
    let lowest = m.add(highest, slack);
    let lowest = m.neg(lowest);
    let (highest, lowest) = (m.as_signed(highest), m.as_signed(lowest));
    let lowest = m.name(lowest, "lowest");
    let places: Vec<Signal> = (0..SIDE).rev().map(|i| m.lit(i, Ty::u(PLACE))).collect();
    let places = m.cat(&places);
    let places = m.name(places, "places");
    let links = [
        ("advance", Feed::Shared(advance)),
        ("start", Feed::Shared(start)),
        ("step", Feed::Shared(step)),
        ("lowest", Feed::Shared(lowest)),
        ("highest", Feed::Shared(highest)),
        ("place", Feed::Each(places)),
    ];
    let all = m.array("place", &place()?, &[("i", SIDE)], &links);
    let near = m.all_out(all, "near");
    m.output("near", near, "place 0 lowest");
    builder.finish()
}
