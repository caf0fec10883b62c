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
        for own in 1..=DIGITS {
            let number = (stage - 1) * DIGITS + own;
            (rest, root, left) = digit(m, (rest, root, left), number);
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

/// One digit, the highest is number 1: the two highest bits that are left join the rest.
fn digit(
    m: &mut ModuleBuilder,
    (rest, root, left): (Signal, Signal, Signal),
    number: u32,
) -> (Signal, Signal, Signal) {
    let named = |m: &mut ModuleBuilder, signal, what: &str| {
        m.name(signal, &format!("{what}_{number}_digits"))
    };
    let width = rest.width();
    let two = m.slice(left, SEARCH_LIMIT - 2, 2);
    let low = m.slice(rest, 0, width - 2);
    let rest = m.cat(&[low, two]);
    let rest = m.name(rest, &format!("rest_for_digit_{number}"));
    let (one, trial) = (m.lit(1, Ty::u(2)), m.slice(root, 0, width - 2));
    let trial = m.cat(&[trial, one]);
    let trial = m.name(trial, &format!("trial_{number}"));
    let fits = m.ge(rest, trial);
    let fits = m.name(fits, &format!("digit_{number}"));
    let less = m.sub(rest, trial);
    let rest = m.mux(fits, less, rest);
    let rest = named(m, rest, "rest_after");
    let kept = m.slice(root, 0, ROOT - 1);
    let root = m.cat(&[kept, fits]);
    let root = named(m, root, "root_after");
    let left = m.shl_const(left, 2);
    (rest, root, named(m, left, "left_after"))
}
