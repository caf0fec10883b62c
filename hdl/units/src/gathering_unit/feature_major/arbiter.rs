//! Arbiter of one bank.

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Ty};

use super::shape::Shape;

/// Builds `bank_arbiter`. In each round a bank serves one row, requested by the lowest waiting
/// lane, to every lane that requests this row.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn bank_arbiter(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let shape = Shape::of(config);
    let (lanes, bits) = (shape.lanes, shape.line_bits);
    let mut builder = ModuleBuilder::new("bank_arbiter");
    let m = &mut builder;
    m.doc(&format!(
        "arbiter of one bank: the lowest of {lanes} lanes that wants it is served, and every lane that wants the same row."
    ));
    let wants = m.input("wants", Ty::u(lanes), "lanes that want this bank");
    let lines = m.input(
        "lines",
        Ty::u(lanes * bits),
        "row of each lane within its bank",
    );
    let negative = m.neg(wants);
    let lowest = m.and(wants, negative);
    let lowest = m.name(lowest, "lowest");
    m.note(lowest, "one bit: the lane that is served first");
    let of_lane: Vec<_> = (0..lanes)
        .map(|lane| {
            let line = m.slice(lines, lane * bits, bits);
            m.name(line, &format!("line_of_lane{lane}"))
        })
        .collect();
    // Bit by bit: at most one lane drives each.
    let mut line = vec![];
    for bit in (0..bits).rev() {
        let column: Vec<_> = of_lane.iter().rev().map(|line| m.bit(*line, bit)).collect();
        let column = m.cat(&column);
        let column = m.name(column, &format!("bit{bit}_of_lanes"));
        let picked = m.and(column, lowest);
        line.push(m.any(picked));
    }
    let line = m.cat(&line);
    let line = m.name(line, "line_served");
    let same: Vec<_> = of_lane.iter().rev().map(|own| m.eq(*own, line)).collect();
    let same = m.cat(&same);
    let same = m.name(same, "same_line");
    let grants = m.and(wants, same);
    let busy = m.any(wants);
    m.output("busy", busy, "some lane wants this bank");
    m.output("line", line, "row that the bank reads");
    m.output("grants", grants, "lanes that get it");
    builder.finish()
}
