//! Rules of the vector unit and its exponential engine.

use std::ops::RangeInclusive;

use crate::config::{Config, ExpBase, ExpConfig, ExpOutput, OperandWidths, RuleBreaches, VuConfig};
use crate::units::OpCode;

/// Signed widths of an operand.
const OPERAND_BITS: RangeInclusive<u32> = 2..=32;

/// Most fraction bits of a sigmoid or softplus: exp(-16) is 0.12 units of 2^-20.
const LOGISTIC_OUTPUT_BITS: u32 = 20;

pub(super) fn vector(config: &Config, out: &mut RuleBreaches) {
    let vu = &config.vu;
    out.range(
        "vu-lanes",
        "vu.lanes",
        vu.lanes,
        1,
        256,
        "lanes side by side",
    );
    out.range(
        "vu-fifo-depth",
        "vu.fifo_depth",
        vu.fifo_depth,
        3,
        64,
        "results that wait for the sink; fewer than 3 stall element-wise operations",
    );
    let mut unique = vu.ops.clone();
    unique.sort();
    unique.dedup();
    out.require(
        !vu.ops.is_empty() && unique.len() == vu.ops.len(),
        "vu-ops",
        "vu.ops",
        OpCode::list(&vu.ops),
        "at least one operation, each once",
    );
    operands(vu, out);
    registered(vu, out);
}

/// Rules of the widths of operands.
fn operands(vu: &VuConfig, out: &mut RuleBreaches) {
    let Some(own) = &vu.operands else { return };
    let [a, b] = own.multiply;
    out.require(
        own.multiply.iter().all(|bits| OPERAND_BITS.contains(bits)),
        "vu-operands-multiply",
        "vu.operands.multiply",
        format_args!("[{a}, {b}]"),
        "two widths of 2 to 32 bits, the sign included: of a and of b",
    );
    out.range(
        "vu-operands-square-sum",
        "vu.operands.square_sum",
        own.square_sum,
        *OPERAND_BITS.start(),
        *OPERAND_BITS.end(),
        "bits of a and of b, the sign included",
    );
    let plain = OperandWidths::default();
    out.require(
        vu.ops.contains(&OpCode::Multiply) || own.multiply == plain.multiply,
        "unused-operands-multiply",
        "vu.operands.multiply",
        format_args!("[{a}, {b}]"),
        "left out, or \"multiply\" in vu.ops: no such operation is built",
    );
    out.require(
        vu.ops.contains(&OpCode::SquareSum) || own.square_sum == plain.square_sum,
        "unused-operands-square-sum",
        "vu.operands.square_sum",
        own.square_sum,
        "left out, or \"square-sum\" in vu.ops: no such operation is built",
    );
}

/// Rules of register stages between operations.
fn registered(vu: &VuConfig, out: &mut RuleBreaches) {
    if !vu.registered {
        return;
    }
    out.require(
        !vu.exp.early_out,
        "vu-registered-early-out",
        "vu.registered",
        true,
        "false, or vu.exp.early_out false: what ends a vector early is known in the clock that it ends",
    );
}

pub(super) fn exponential(config: &Config, out: &mut RuleBreaches) {
    let exp = &config.vu.exp;
    let (n, f) = (exp.iterations, exp.output_bits);
    let offers = exp.form.offers();
    let (least, most, why) = exp.form.iterations();
    out.range("exp-iterations", "vu.exp.iterations", n, least, most, why);
    if !(least..=most).contains(&n) {
        return;
    }
    out.require(
        exp.output == ExpOutput::Alpha || offers.general,
        "exp-form-output",
        "vu.exp.output",
        "general",
        "\"alpha\": the general output is of vu.exp.form = \"restoring\"",
    );
    out.require(
        exp.base == ExpBase::E || offers.base_two,
        "exp-base",
        "vu.exp.base",
        "two",
        "\"e\": powers of two are of vu.exp.form = \"piecewise\"",
    );
    exp.rules_of_form(out);
    let most = if exp.output == ExpOutput::Alpha {
        24
    } else {
        23
    };
    out.range(
        "exp-output-bits",
        "vu.exp.output_bits",
        f,
        4,
        most,
        "fraction bits of the result, which has 32 in all",
    );
    out.range(
        "exp-one-minus-frac-bits",
        "vu.exp.one_minus_frac_bits",
        exp.one_minus_frac_bits,
        8,
        24,
        "the input covers 0 to 16",
    );
    let (right, wanted) = exp.form.input(exp.input, exp.output);
    out.require(
        right && (4..=24).contains(&exp.input.frac_bits()),
        "exp-input",
        "vu.exp.input",
        exp.input,
        wanted,
    );
    if !out.is_empty() && out.0.iter().any(|b| b.field.starts_with("vu.exp")) {
        return;
    }
    widths(config, out);
}

/// Rules that relate widths, steps and operations.
fn widths(config: &Config, out: &mut RuleBreaches) {
    let exp = &config.vu.exp;
    let offers = exp.form.offers();
    let engine = exp.engine();
    out.range(
        "exp-iterations-per-clock",
        "vu.exp.iterations_per_clock",
        exp.iterations_per_clock,
        1,
        engine.steps.max(1),
        "steps taken in one clock, of n and the exponent's digits",
    );
    out.range(
        "exp-accumulator-bits",
        "vu.exp.accumulator_bits",
        engine.accumulator_bits,
        exp.output_bits,
        40,
        "at least the result's fraction bits",
    );
    let (least, why) = exp.least_constant_bits();
    out.range(
        "exp-constant-bits",
        "vu.exp.constant_bits",
        exp.constant_bits.unwrap_or(engine.constant_bits),
        least,
        40,
        why,
    );
    out.require(
        (-16..=16).contains(&engine.offset),
        "exp-offset",
        "vu.exp.offset",
        engine.offset,
        "-16 to 16 units of the accumulator's last bit",
    );
    out.require(
        offers.tail || !exp.tail,
        "exp-literal-tail",
        "vu.exp.tail",
        exp.tail,
        format_args!("false: the {} recurrence has no tail", exp.form.name()),
    );
    let one_minus = config.vu.ops.contains(&OpCode::OneMinusExp);
    out.require(
        !one_minus || (offers.one_minus && exp.output == ExpOutput::Alpha),
        "exp-one-minus",
        "vu.ops",
        "one-minus-exp",
        "left out: it needs vu.exp.output = \"alpha\" and a vu.exp.form other than \"literal\"",
    );
    if exp.early_out {
        early_out(exp, out);
    }
    logistic(config, out);
}

/// Rules of early termination.
fn early_out(exp: &ExpConfig, out: &mut RuleBreaches) {
    out.require(
        exp.form.offers().early_out && exp.output == ExpOutput::Alpha,
        "exp-early-out",
        "vu.exp.early_out",
        true,
        "false: it is of vu.exp.form = \"restoring\" and vu.exp.output = \"alpha\"",
    );
    out.require(
        !exp.pipelined && !exp.tail,
        "exp-early-out-iterative",
        "vu.exp.early_out",
        true,
        "false, or vu.exp.pipelined and vu.exp.tail false: stages and tail come at fixed clocks",
    );
    let (earliest, interval) = (exp.earliest_out(), exp.interval());
    out.require(
        earliest < interval,
        "exp-early-out-clocks",
        "vu.exp.early_out",
        true,
        format_args!(
            "false: all iterations take {interval} clocks, and the lanes agree to stop after {earliest} at the \
             earliest"
        ),
    );
}

/// Rules of sigmoid and softplus, where built.
fn logistic(config: &Config, out: &mut RuleBreaches) {
    let exp = &config.vu.exp;
    let built: Vec<_> = config
        .vu
        .ops
        .iter()
        .copied()
        .filter(|op| op.is_logistic())
        .collect();
    if built.is_empty() {
        return;
    }
    out.require(
        exp.form.offers().logistic && exp.output == ExpOutput::Alpha,
        "exp-logistic",
        "vu.ops",
        OpCode::list(&built),
        "left out: sigmoid and softplus need vu.exp.form = \"restoring\" and vu.exp.output = \"alpha\"",
    );
    out.require(
        !exp.early_out,
        "exp-logistic-early-out",
        "vu.exp.early_out",
        exp.early_out,
        "false, or sigmoid and softplus left out of vu.ops: their later passes need every iteration",
    );
    out.require(
        !exp.pipelined,
        "exp-logistic-pipelined",
        "vu.exp.pipelined",
        exp.pipelined,
        "false, or sigmoid and softplus left out of vu.ops: they take the engine two or three times, \
         and a pipeline passes it once",
    );
    out.require(
        exp.output_bits <= LOGISTIC_OUTPUT_BITS,
        "exp-logistic-output-bits",
        "vu.exp.output_bits",
        exp.output_bits,
        format_args!(
            "at most {LOGISTIC_OUTPUT_BITS} with sigmoid or softplus: exp(-16), where their exponentials end, \
             must round to 0"
        ),
    );
}
