//! One lane: element-wise operations and the exponential engine.

use std::sync::Arc;

use num_bigint::BigInt;
use potamoi_formats::config::Config;
use potamoi_formats::timing::Pipeline;
use potamoi_netlist::{IrErrors, Module, ModuleBuilder, Signal, Ty};

use super::alu::{addends, beyond, exact, exact_type, shifted};
use super::exponential;
use super::lane_control::LaneControl;
use super::operation_kinds::OperationKinds;
use crate::circuits::{bits_for, delayed, held};
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
    let control = LaneControl::declare(m, &config.vu, kinds);
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
    let plain = kinds
        .elementwise
        .then(|| element_wise(m, config, &control, a, b));
    let powers = kinds.exp.then(|| {
        let form = widths.form;
        form.powers(m, config, &widths, &control, a)
    });
    m.section("Result stage");
    let value = plain.map(|held| {
        let shifted = shifted(m, held, control.shift);
        match config.vu.registered {
            true => shifted.rounded_a_clock_later(m, control.rounding),
            false => shifted.rounded(m, control.rounding),
        }
    });
    let value = match (value, exp.pipelined && kinds.exp) {
        (Some(v), true) => {
            let own = Pipeline::element_wise(config.vu.registered).cycles();
            let stages = exp.interval() + config.vu.lag() - own;
            Some(delayed(m, "value_stages", v, stages, None).0)
        }
        (v, _) => v,
    };
    let more = powers.as_ref().and_then(|p| p.more);
    let remainders = powers.as_ref().map_or(vec![], |p| p.remainders.clone());
    let power = powers.map(|p| {
        let result = widths.result(m, &p, control.was_one_minus, config.vu.registered);
        match p.logistic.filter(|_| kinds.softplus) {
            Some((_, sum)) => {
                let mut softplus = widths.softplus(m, sum);
                // The sum was registered a clock before the result stage needs it.
                if config.vu.registered {
                    softplus = held(m, "softplus_result", softplus);
                }
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
    if config.vu.has_narrow_operands() {
        let beyond = beyond(m, &config.vu, &control, a, b);
        let kept = m.bit(keep, 0);
        let beyond = m.and(beyond, kept);
        m.output(
            "beyond",
            beyond,
            "an operand of a kept lane is beyond its width",
        );
    }
    if let Some(more) = more {
        m.output("more", more, "has steps to take after the next clock");
    }
    if kinds.elementwise {
        let registers: &[&str] = match config.vu.registered {
            true => &["addend0", "addend1"],
            false => &["exact"],
        };
        let held = registers.iter().map(|register| Held {
            register: (*register).to_owned(),
            enable: "accept",
        });
        held_without_enable(m, &held.collect::<Vec<_>>());
    }
    remainder_checks(m, &remainders);
    builder.finish()
}

/// The exact result of an element-wise operation, a clock or two after its operands.
fn element_wise(
    m: &mut ModuleBuilder,
    config: &Config,
    control: &LaneControl,
    a: Signal,
    b: Signal,
) -> Signal {
    let vu = &config.vu;
    m.section("Element-wise operations");
    if !vu.registered {
        let next = exact(m, vu, control.code, a, b);
        let held = m.data_reg("exact", exact_type(vu));
        m.set_next_if(held, control.accept, next);
        return held;
    }
    let next = addends(m, vu, &control.asked, a, b);
    let [one, other] = [0, 1].map(|i| {
        let reg = m.data_reg(&format!("addend{i}"), next[i].ty());
        m.set_next_if(reg, control.accept, next[i]);
        reg
    });
    let sum = m.add(one, other);
    let sum = m.as_signed(sum);
    let held = m.data_reg("exact", exact_type(vu));
    m.set_next(held, sum);
    held
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
