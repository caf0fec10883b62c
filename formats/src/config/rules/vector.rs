//! The rules of the vector unit and its exponential engine.

use super::RuleBreaches;
use crate::config::{Config, ExpBase, ExpConfig, ExpForm, ExpOutput};
use crate::units::OpCode;

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
}

pub(super) fn exponential(config: &Config, out: &mut RuleBreaches) {
    let exp = &config.vu.exp;
    let (n, f) = (exp.iterations, exp.output_bits);
    let (least, most, why) = match exp.form {
        ExpForm::Radix4 => (1, 15, "digits of radix 4, whose shift amount has 5 bits"),
        _ => (2, 31, "the shift amount has 5 bits"),
    };
    out.range("exp-iterations", "vu.exp.iterations", n, least, most, why);
    if !(least..=most).contains(&n) {
        return;
    }
    out.require(
        exp.output == ExpOutput::Alpha || matches!(exp.form, ExpForm::Restoring | ExpForm::Literal),
        "exp-form-output",
        "vu.exp.output",
        "general",
        "\"alpha\": the general output is of vu.exp.form = \"restoring\"",
    );
    out.require(
        exp.base == ExpBase::E || exp.form == ExpForm::Piecewise,
        "exp-base",
        "vu.exp.base",
        "two",
        "\"e\": powers of two are of vu.exp.form = \"piecewise\"",
    );
    if exp.form == ExpForm::Piecewise {
        pieces(exp, out);
    }
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
    let (wanted, right) = match (exp.form, exp.output) {
        (ExpForm::Literal, _) => (
            "S0.4 to S0.24: the recurrence covers [-1, 1)",
            exp.input.is_signed() && exp.input.int_bits() == 0,
        ),
        (_, ExpOutput::Alpha) => (
            "U1.x to U3.x with 4 to 24 fraction bits: the digits cover 0 to 8",
            !exp.input.is_signed() && (1..=3).contains(&exp.input.int_bits()),
        ),
        (_, ExpOutput::General) => (
            "S0.x to S6.x with 4 to 24 fraction bits",
            exp.input.is_signed() && exp.input.int_bits() <= 6,
        ),
    };
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
        f,
        40,
        "at least the result's fraction bits",
    );
    let (least, why) = match exp.form {
        ExpForm::Piecewise => (
            exp.input.frac_bits().max(exp.piece_widths().index_bits + 4),
            "at least the input's fraction bits, and 4 beyond those that name a piece",
        ),
        _ => (exp.input.frac_bits(), "at least the input's fraction bits"),
    };
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
        exp.form != ExpForm::Literal || !exp.tail,
        "exp-literal-tail",
        "vu.exp.tail",
        exp.tail,
        "false: the literal recurrence has no tail",
    );
    let one_minus = config.vu.ops.contains(&OpCode::OneMinusExp);
    out.require(
        !one_minus || (exp.form != ExpForm::Literal && exp.output == ExpOutput::Alpha),
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

/// The exponential in straight pieces.
fn pieces(exp: &ExpConfig, out: &mut RuleBreaches) {
    let count = exp.pieces;
    out.require(
        count.is_power_of_two() && (16..=1024).contains(&count),
        "exp-pieces",
        "vu.exp.pieces",
        count,
        "a power of two, 16 to 1024: the first bits of the power name the piece",
    );
    out.require(
        exp.pipelined,
        "exp-pieces-pipelined",
        "vu.exp.pipelined",
        exp.pipelined,
        "true: the pieces give one result a clock",
    );
    let most = 2 * count.max(1).ilog2() + 4;
    out.require(
        exp.output_bits <= most,
        "exp-pieces-output-bits",
        "vu.exp.output_bits",
        exp.output_bits,
        format_args!(
            "at most {most} with {count} pieces, whose error is then below half a unit, so that 1 - exp(0) is 0"
        ),
    );
    for (unset, field, value) in [
        (!exp.tail, "vu.exp.tail", exp.tail.to_string()),
        (
            exp.offset.is_none(),
            "vu.exp.offset",
            exp.offset.unwrap_or_default().to_string(),
        ),
        (
            !exp.early_out,
            "vu.exp.early_out",
            exp.early_out.to_string(),
        ),
    ] {
        out.require(
            unset,
            "exp-pieces-knobs",
            field,
            value,
            "left out: the pieces take no iterations",
        );
    }
}

/// Iterations left out where the exponent needs fewer.
fn early_out(exp: &ExpConfig, out: &mut RuleBreaches) {
    out.require(
        exp.form == ExpForm::Restoring && exp.output == ExpOutput::Alpha,
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

/// Sigmoid and softplus, where they are built.
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
        exp.form == ExpForm::Restoring && exp.output == ExpOutput::Alpha,
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
