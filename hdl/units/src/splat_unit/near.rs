//! The places of a row, or the rows of a tile, at which a form is near enough.

use std::sync::Arc;

use potamoi_formats::record::FACTOR;
use potamoi_netlist::{Feed, IrErrors, Module, ModuleBuilder, Ty};

use super::formats::{AT_ROW, COMPARE, EXACT, ROOT, SEARCH, STEP};
use super::product::multiples;

/// Pixels of a row, rows of a tile.
pub(super) const SIDE: u32 = 16;
/// Bits of a place.
pub(super) const PLACE: u32 = SIDE.ilog2();
/// Bits of a start value in the search.
const START: u32 = AT_ROW - EXACT + SEARCH;
/// Bits of a step in the search.
const COARSE_STEP: u32 = STEP - FACTOR.frac_bits() + SEARCH;
/// Bits of what a form grows up to a place.
const GROWN: u32 = COARSE_STEP + PLACE;
/// Bits of a bound: a root, or what is less than its opposite, with a sign.
const BOUND: u32 = ROOT + 2;
/// Units below the opposite of the root that count as near: what cutting off may add.
const SLACK: u32 = 2;

/// Builds `splat_place`: whether a form is near enough at one place. The bounds are those of the clock
/// after its start value.
fn place() -> Result<Arc<Module>, IrErrors> {
    let mut builder = ModuleBuilder::new("splat_place");
    let m = &mut builder;
    m.doc("whether a form is near enough at a place: of the form of the clock before.");
    let takes = m.input("takes_start", Ty::bit(), "takes the form over");
    let start = m.input("start", Ty::s(START), "the form at place 0");
    let grown = m.input("grown", Ty::s(GROWN), "what it has grown since");
    let bounds = ["lowest", "highest"].map(|name| m.input(name, Ty::s(BOUND), ""));
    let width = START + 1;
    let (grown, start) = (m.extend(grown, width), m.extend(start, width));
    let at = m.add(start, grown);
    let at = m.name(at, "form_at_place");
    let dropped = SEARCH - COMPARE;
    let at = m.slice(at, dropped, width - dropped);
    let at = m.as_signed(at);
    let register = m.data_reg("form", at.ty());
    m.set_next_if(register, takes, at);
    let at = register;
    let [lowest, highest] = bounds.map(|bound| m.extend(bound, at.width()));
    let (above, below) = (m.ge(at, lowest), m.le(at, highest));
    let near = m.and(above, below);
    m.output("near", near, "");
    builder.finish()
}

/// Builds `splat_near`: the places 0 to 15 at which a form lies between the root, and its opposite less
/// the slack. The step is that of two clocks before; start value and root are those of the clock before.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn near() -> Result<Arc<Module>, IrErrors> {
    let mut builder = ModuleBuilder::new("splat_near");
    let m = &mut builder;
    m.doc("the places at which a form is near enough.");
    let [step_moves, start_moves, root_moves] =
        ["takes_step", "takes_start", "takes_root"].map(|name| m.input(name, Ty::bit(), ""));
    let start = m.input("start", Ty::s(AT_ROW), "the exact form at place 0");
    let step = m.input("step", Ty::s(STEP), "what it grows by a place");
    let root = m.input("root", Ty::u(ROOT), "the largest that is near");
    let start = m.slice(start, EXACT - SEARCH, START);
    let start = m.as_signed(start);
    let step = m.slice(step, STEP - COARSE_STEP, COARSE_STEP);
    let step = m.as_signed(step);
    let step = m.name(step, "coarse_step");
    let highest = m.extend(root, BOUND);
    let highest = m.name(highest, "root_wide");
    let slack = m.lit(SLACK, highest.ty());
    let lowest = m.add(highest, slack);
    let lowest = m.neg(lowest);
    let (highest, lowest) = (m.as_signed(highest), m.as_signed(lowest));
    let [lowest, highest] = [("lowest", lowest), ("highest", highest)].map(|(name, bound)| {
        let register = m.data_reg(name, bound.ty());
        m.set_next_if(register, root_moves, bound);
        register
    });
    let mut grown = multiples(m, step, step_moves);
    grown.reverse();
    let grown = m.cat(&grown);
    let grown = m.name(grown, "grown_at_places");
    let links = [
        ("takes_start", Feed::Shared(start_moves)),
        ("start", Feed::Shared(start)),
        ("lowest", Feed::Shared(lowest)),
        ("highest", Feed::Shared(highest)),
        ("grown", Feed::Each(grown)),
    ];
    let all = m.array("place", &place()?, &[("i", SIDE)], &links);
    let near = m.all_out(all, "near");
    m.output("near", near, "place 0 lowest");
    builder.finish()
}
