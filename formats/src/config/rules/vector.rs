//! The rules of the vector unit and its exponential engine.

use super::RuleBreaches;
use crate::config::{Config, ExpForm, ExpOutput};
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
    out.range(
        "exp-iterations",
        "vu.exp.iterations",
        n,
        2,
        31,
        "the shift amount has 5 bits",
    );
    if !(2..=31).contains(&n) {
        return;
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
        engine.steps,
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
    let least = exp.input.frac_bits();
    out.range(
        "exp-constant-bits",
        "vu.exp.constant_bits",
        exp.constant_bits.unwrap_or(engine.constant_bits),
        least,
        40,
        "at least the input's fraction bits",
    );
    out.require(
        (-16..=16).contains(&engine.offset),
        "exp-offset",
        "vu.exp.offset",
        engine.offset,
        "-16 to 16 units of the accumulator's last bit",
    );
    out.require(
        exp.form == ExpForm::Restoring || !exp.tail,
        "exp-literal-tail",
        "vu.exp.tail",
        exp.tail,
        "false: the literal recurrence has no tail",
    );
    let one_minus = config.vu.ops.contains(&OpCode::OneMinusExp);
    out.require(
        !one_minus || (exp.form == ExpForm::Restoring && exp.output == ExpOutput::Alpha),
        "exp-one-minus",
        "vu.ops",
        "one-minus-exp",
        "left out: it needs vu.exp.form = \"restoring\" and vu.exp.output = \"alpha\"",
    );
    logistic(config, out);
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
        format!(
            "at most {LOGISTIC_OUTPUT_BITS} with sigmoid or softplus: exp(-16), where their exponentials end, \
             must round to 0"
        ),
    );
}
