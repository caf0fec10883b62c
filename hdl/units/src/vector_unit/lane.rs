//! One lane: element-wise operations and the exponential engine.

use std::sync::Arc;

use num_bigint::BigInt;
use potamoi_formats::config::Config;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Ty};

use super::alu::{EXACT, exact, requantise};
use super::exponential;
use super::lane_control::LaneControl;
use super::operation_kinds::OperationKinds;
use crate::circuits::{bits_for, delayed};
use crate::data_checks::{Held, held_without_enable};

/// Builds `vector_lane`.
///
/// # Errors
/// The netlist's own checks.
pub(super) fn lane(config: &Config) -> Result<Arc<Module>, IrErrors> {
    let exp = &config.vu.exp;
    let kinds = OperationKinds::of(config);
    let widths = exponential::widths(exp, kinds);
    let mut builder = ModuleBuilder::new("vector_lane");
    let m = &mut builder;
    m.doc("one lane of the vector unit: element-wise operations and the exponential engine.");
    let control = LaneControl::declare(m, kinds);
    let a = m.input("a", Ty::s(32), "");
    let b = m.input("b", Ty::s(32), "");
    let reads_b = config.vu.ops.iter().any(|o| o.takes_both());
    if !reads_b {
        m.unused(b, "No operation that is built takes a second operand.");
    }
    let keep = m.input(
        "keep",
        Ty::u(8),
        "bytes of a and b that are kept: all or none",
    );
    let result_keep = m.input("result_keep", Ty::bit(), "of the result stage");
    if !kinds.elementwise {
        m.unused(
            control.accept,
            "The exponential engine is told when to begin instead.",
        );
    }
    let plain = kinds.elementwise.then(|| {
        m.section("Element-wise operations");
        let next = exact(m, &config.vu.ops, control.code, a, b);
        let held = m.data_reg("exact", EXACT);
        m.set_next_if(held, control.accept, next);
        held
    });
    let powers = kinds.exp.then(|| {
        let form = widths.form;
        form.powers(m, config, &widths, &control, a)
    });
    m.section("Result stage");
    let value = plain.map(|held| requantise(m, held, control.shift, control.rounding));
    let value = match (value, exp.pipelined && kinds.exp) {
        (Some(v), true) => Some(delayed(m, "value_stages", v, exp.interval() - 1, None).0),
        (v, _) => v,
    };
    let more = powers.as_ref().and_then(|p| p.more);
    let remainders = powers.as_ref().map_or(vec![], |p| p.remainders.clone());
    let power = powers.map(|p| {
        let result = widths.result(m, &p, control.was_one_minus);
        match p.logistic.filter(|_| kinds.softplus) {
            Some((_, sum)) => {
                let softplus = widths.softplus(m, sum);
                m.mux(control.was_softplus, softplus, result)
            }
            None => result,
        }
    });
    let result = match (value, power) {
        (Some(v), Some(p)) => m.mux(control.is_exp, p, v),
        (Some(only), None) | (None, Some(only)) => only,
        (None, None) => m.lit(0, Ty::u(32)),
    };
    let mask = m.repeat(result_keep, 32);
    let result = m.and(result, mask);
    m.output("result", result, "of the result stage; 0 if it is not kept");
    let (some, all) = (m.any(keep), m.all(keep));
    let torn = m.xor(some, all);
    m.output("torn", torn, "some bytes are kept and some are not");
    if let Some(more) = more {
        m.output("more", more, "has steps to take after the next clock");
    }
    if kinds.elementwise {
        let register = "exact".to_owned();
        let enable = "accept";
        held_without_enable(m, &[Held { register, enable }]);
    }
    remainder_checks(m, &remainders);
    builder.finish()
}

/// Each clock of a pipelined exponential leaves at most so much of the remainder, once its registers
/// are filled.
fn remainder_checks(m: &mut ModuleBuilder, remainders: &[(String, BigInt)]) {
    let stages = remainders.len();
    if stages == 0 {
        return;
    }
    m.begin_checks();
    m.checking();
    let filled = m.ghost_data_reg("filled", bits_for(stages as u32));
    m.ghost_next(
        filled,
        "1",
        &format!("if(checking, if(filled == {stages}, {stages}, filled + 1), 0)"),
    );
    m.invariant("filled_in_range", &format!("filled <= {stages}"), "");
    m.ghost("is_filled", &format!("filled == {stages}"));
    let bounds = remainders.iter().enumerate();
    let bounds: Vec<String> = bounds
        .map(|(stage, (register, most))| format!("(filled >= {stage} -> {register} <= {most})"))
        .collect();
    m.assert(
        "remainders_bounded",
        &bounds.join(" & "),
        "Of the remainder no step leaves more than its constant resolves.",
    );
    m.cover("fills", "is_filled", "All stages hold an operand.");
}
