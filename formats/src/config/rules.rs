//! The rules that a configuration must keep, each with a name.

use std::fmt;

use super::{Config, ExpForm, ExpOutput, Modes};
use crate::rit::Vertices;
use crate::units::OpCode;

/// Most fraction bits of a sigmoid or softplus: exp(-16) is 0.12 units of 2^-20.
const LOGISTIC_OUTPUT_BITS: u32 = 20;

/// One broken rule.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct RuleBreach {
    /// The rule's name.
    pub rule: &'static str,
    /// The field, as a TOML path.
    pub field: &'static str,
    /// The value found.
    pub value: String,
    /// What would be right, and why.
    pub expected: String,
}

/// Broken rules, in the order of the fields.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct RuleBreaches(pub Vec<RuleBreach>);

impl RuleBreaches {
    /// Whether every rule is kept.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    fn require(
        &mut self,
        kept: bool,
        rule: &'static str,
        field: &'static str,
        value: impl fmt::Display,
        expected: impl Into<String>,
    ) {
        if !kept {
            self.0.push(RuleBreach {
                rule,
                field,
                value: value.to_string(),
                expected: expected.into(),
            });
        }
    }

    fn range(
        &mut self,
        rule: &'static str,
        field: &'static str,
        value: u32,
        low: u32,
        high: u32,
        why: &str,
    ) {
        self.require(
            (low..=high).contains(&value),
            rule,
            field,
            value,
            format!("{low} to {high}: {why}"),
        );
    }
}

impl fmt::Display for RuleBreach {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "rule `{}`: {} = {}; expected {}",
            self.rule, self.field, self.value, self.expected
        )
    }
}

impl fmt::Display for RuleBreaches {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, breach) in self.0.iter().enumerate() {
            if i > 0 {
                f.write_str("\n")?;
            }
            write!(f, "{breach}")?;
        }
        Ok(())
    }
}

/// Every rule that `config` breaks.
#[must_use]
pub fn check(config: &Config) -> RuleBreaches {
    let mut out = RuleBreaches::default();
    out.range(
        "clock",
        "clock_mhz",
        config.clock_mhz,
        1,
        10_000,
        "it turns cycles into time",
    );
    gathering(config, &mut out);
    index_table(config, &mut out);
    vector(config, &mut out);
    exponential(config, &mut out);
    out
}

fn gathering(config: &Config, out: &mut RuleBreaches) {
    let gu = &config.gu;
    out.range(
        "mvoxel-rows",
        "mvoxel.rows",
        config.mvoxel.rows,
        2,
        65_536,
        "a row is named by 16 bits of an id",
    );
    out.range(
        "gu-banks",
        "gu.banks",
        gu.banks,
        1,
        64,
        "channels read in one cycle",
    );
    out.range(
        "gu-ports",
        "gu.ports",
        gu.ports,
        1,
        8,
        "entries processed side by side",
    );
    out.range(
        "gu-feature-bits",
        "gu.feature_bits",
        gu.feature_bits,
        8,
        16,
        "a feature sits in a 16-bit lane",
    );
    out.range(
        "gu-weight-bits",
        "gu.weight_bits",
        gu.weight_bits,
        4,
        15,
        "a weight sits in 16 bits as U1.W",
    );
    out.range(
        "gu-segments",
        "gu.segments",
        gu.segments,
        1,
        64,
        "passes over an MVoxel's entries",
    );
    out.range(
        "gu-fifo-depth",
        "gu.fifo_depth",
        gu.fifo_depth,
        4,
        1024,
        "fewer than 4 beats stall single-id entries even with a ready sink",
    );
    out.range(
        "gu-counter-bits",
        "gu.counter_bits",
        gu.counter_bits,
        16,
        64,
        "width of the cycle and stall counters",
    );
    if gu.modes != Modes::Unstructured {
        let listed = || {
            gu.vertices
                .iter()
                .map(|v| v.count().to_string())
                .collect::<Vec<_>>()
                .join(", ")
        };
        let mut unique = gu.vertices.clone();
        unique.sort();
        unique.dedup();
        out.require(
            !gu.vertices.is_empty() && unique.len() == gu.vertices.len() && !gu.vertices.contains(&Vertices::One),
            "gu-vertices",
            "gu.vertices",
            format!("[{}]", listed()),
            "at least one of 8, 4 and 2, each once; single ids are gu.modes = \"unstructured\" or \"both\"",
        );
    }
}

fn index_table(config: &Config, out: &mut RuleBreaches) {
    let (rit, ports) = (&config.rit, config.gu.ports.max(1));
    out.require(
        rit.entries.is_multiple_of(ports) && (ports..=65_536).contains(&rit.entries),
        "rit-entries",
        "rit.entries",
        rit.entries,
        format!(
            "a multiple of gu.ports = {ports}, from {ports} to 65536, such as {}: {ports} entries are read together",
            (rit.entries.min(65_536) / ports * ports).max(ports)
        ),
    );
    let (stream, row) = (config.rit_stream_bits(), config.rit_row_bits());
    // Without a port there is no row to divide.
    out.require(
        config.gu.ports == 0 || stream >= 32 && stream.is_multiple_of(32) && row.is_multiple_of(stream),
        "rit-stream-bits",
        "rit.stream_bits",
        stream,
        format!("a multiple of 32 that divides the {row} bits of one RIT row ({ports} entries of 48 bytes)"),
    );
    out.require(
        rit.slot_bits == 16 || rit.slot_bits == 32,
        "rit-slot-bits",
        "rit.slot_bits",
        rit.slot_bits,
        "16 or 32: the tag of word 0, or those of words 0 and 1",
    );
    out.require(
        rit.slot_bits != 32 || config.gu.modes == Modes::Structured,
        "rit-slot-words",
        "rit.slot_bits",
        rit.slot_bits,
        "16, since single-id entries carry one tag; or gu.modes = \"structured\"",
    );
}

fn vector(config: &Config, out: &mut RuleBreaches) {
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

fn exponential(config: &Config, out: &mut RuleBreaches) {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// One configuration for every rule; the snapshot shows what a user sees.
    #[test]
    fn every_rule_refuses_with_its_name() {
        let cases = [
            "clock_mhz = 0",
            "[mvoxel]\nrows = 1",
            "[gu]\nbanks = 65",
            "[gu]\nports = 0",
            "[gu]\nfeature_bits = 7",
            "[gu]\nweight_bits = 16",
            "[gu]\nsegments = 0",
            "[gu]\nfifo_depth = 3",
            "[gu]\ncounter_bits = 8",
            "[gu]\nvertices = [1, 8]",
            "[gu]\nvertices = []",
            "[rit]\nentries = 127",
            "[rit]\nstream_bits = 80",
            "[rit]\nslot_bits = 24",
            "[rit]\nslot_bits = 32",
            "[vu]\nlanes = 0",
            "[vu]\nfifo_depth = 1",
            "[vu]\nops = [\"exp\", \"exp\"]",
            "[vu.exp]\niterations = 32",
            "[vu.exp]\noutput_bits = 25",
            "[vu.exp]\none_minus_frac_bits = 30",
            "[vu.exp]\ninput = \"S3.12\"",
            "[vu.exp]\noutput = \"general\"",
            "[vu.exp]\nform = \"literal\"",
            "[vu.exp]\niterations_per_clock = 21",
            "[vu.exp]\naccumulator_bits = 15",
            "[vu.exp]\nconstant_bits = 12",
            "[vu.exp]\noffset = 17",
            "[vu]\nops = [\"exp\"]\n[vu.exp]\nform = \"literal\"\ninput = \"S0.15\"\ntail = true",
            "[vu.exp]\noutput = \"general\"\ninput = \"S3.12\"",
            "[vu]\nops = [\"exp\", \"sigmoid\"]\n[vu.exp]\noutput = \"general\"\ninput = \"S3.12\"",
            "[vu]\nops = [\"sigmoid\", \"softplus\"]\n[vu.exp]\npipelined = true",
            "[vu]\nops = [\"softplus\"]\n[vu.exp]\noutput_bits = 21",
        ];
        let mut seen = String::new();
        for text in cases {
            let config: Config = toml::from_str(text).unwrap();
            let breaches = check(&config);
            assert!(!breaches.is_empty(), "accepted:\n{text}");
            seen += &format!(
                "{}\n  {}\n",
                text.replace('\n', " "),
                breaches.to_string().replace('\n', "\n  ")
            );
        }
        insta::assert_snapshot!(seen);
    }

    #[test]
    fn the_whole_stated_range_is_accepted() {
        for banks in [1, 2, 31, 32, 64] {
            for ports in 1..=8 {
                for entries in [ports, 3 * ports, 128 / ports * ports] {
                    let text = format!(
                        "[gu]\nbanks = {banks}\nports = {ports}\n[rit]\nentries = {entries}"
                    );
                    let config: Config = toml::from_str(&text).unwrap();
                    assert!(check(&config).is_empty(), "{text}: {}", check(&config));
                }
            }
        }
        for n in 2..=31 {
            for tail in [false, true] {
                for r in [1, 3, 4 + n] {
                    let text = format!(
                        "[vu.exp]\niterations = {n}\ntail = {tail}\niterations_per_clock = {r}"
                    );
                    let config: Config = toml::from_str(&text).unwrap();
                    assert!(check(&config).is_empty(), "{text}: {}", check(&config));
                }
            }
        }
    }
}
