//! Integer square root, two digits a clock.

use std::sync::Arc;

use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::formats::{ROOT, SEARCH_LIMIT};

/// Digits of the root that a clock finds.
const DIGITS: u32 = 2;
/// Clocks from a square to its root.
pub(super) const CLOCKS: u32 = ROOT / DIGITS;

/// Builds `splat_root`: the largest integer whose square is at most the input.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn root() -> Result<Arc<Module>, IrErrors> {
    let mut builder = ModuleBuilder::new("splat_root");
    let m = &mut builder;
    m.doc(&format!(
        "integer square root of {SEARCH_LIMIT} bits, rounded down; a pipeline of {CLOCKS} clocks."
    ));
    let advance = m.input("advance", Ty::bit(), "the pipeline moves");
    let square = m.input("square", Ty::u(SEARCH_LIMIT), "");
    let mut rest = m.lit(0, Ty::u(ROOT + 2));
    let mut root = m.lit(0, Ty::u(ROOT));
    let mut left = square;
    for stage in 1..=CLOCKS {
        for _ in 0..DIGITS {
            (rest, root, left) = digit(m, rest, root, left);
        }
        let keep = |m: &mut ModuleBuilder, name: &str, value: Signal| {
            let register = m.data_reg(&format!("{name}_{stage}"), value.ty());
            m.set_next_if(register, advance, value);
            register
        };
        root = keep(m, "root", root);
        if stage < CLOCKS {
            rest = keep(m, "rest", rest);
            left = keep(m, "left", left);
        }
    }
    m.output("root", root, "of the square so many moves before");
    builder.finish()
}

/// One digit: the two highest bits that are left join the rest.
fn digit(
    m: &mut ModuleBuilder,
    rest: Signal,
    root: Signal,
    left: Signal,
) -> (Signal, Signal, Signal) {
    let width = rest.width();
    let two = m.slice(left, SEARCH_LIMIT - 2, 2);
    let low = m.slice(rest, 0, width - 2);
    let rest = m.cat(&[low, two]);
    let (one, trial) = (m.lit(1, Ty::u(2)), m.slice(root, 0, width - 2));
    let trial = m.cat(&[trial, one]);
    let fits = m.ge(rest, trial);
    let less = m.sub(rest, trial);
    let rest = m.mux(fits, less, rest);
    let kept = m.slice(root, 0, ROOT - 1);
    let root = m.cat(&[kept, fits]);
    (rest, root, m.shl_const(left, 2))
}
