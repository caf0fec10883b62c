//! `potamoi cost --study exp`: every input of the exponential through the Verilated unit.

use std::fmt::Write as _;

use potamoi_cycles::Stalls;
use potamoi_formats::config::{Config, ExpBase, ExpConfig, ExpForm, ExpOutput};
use potamoi_formats::fixed::Format;
use potamoi_formats::units::{OpCode, VectorOp};
use potamoi_reference::reference::{ExpError, Reference};
use potamoi_reference::widths::{budget, straightness, truncation};
use potamoi_rtl::{VectorBatch, VectorUnit};
use potamoi_units::vector_unit::error_bound;
use serde::Serialize;

use super::{CostArgs, FORMAT_VERSION};
use crate::failure::Failure;
use crate::files;
use crate::progress;
use crate::stdout::say;

/// Bits of an input that is swept wholly.
const INPUT_BITS: u32 = 16;

#[derive(Serialize)]
struct Report {
    format_version: u32,
    command: &'static str,
    unit: &'static str,
    /// 12 hexadecimal digits.
    configuration: String,
    inputs: usize,
    /// "restoring", "piecewise" or "radix-4".
    form: ExpForm,
    /// What is raised to a power.
    base: ExpBase,
    /// Of the piecewise form: pieces, and bits of their table.
    #[serde(skip_serializing_if = "Option::is_none")]
    pieces: Option<Table>,
    early_out: bool,
    iterations: u32,
    tail: bool,
    /// Fraction bits of accumulator and constants, start of the accumulator.
    accumulator_bits: u32,
    constant_bits: u32,
    offset: i32,
    output_bits: u32,
    /// Largest and mean magnitude of the error, in units of the last place.
    max_ulp: f64,
    mean_ulp: f64,
    bias_ulp: f64,
    /// Input with the largest error.
    worst_code: i32,
    /// Results that are not the nearest code.
    misrounded: u32,
    monotone: bool,
    /// The part of it that cutting off after n iterations, or straight pieces,
    /// may cost.
    truncation_ulp: f64,
    /// What all roundings together may cost.
    budget_ulp: f64,
    /// By analysis of the netlist.
    netlist_ulp: Option<f64>,
    /// The part of it that dropped bits are.
    netlist_dropped_ulp: Option<f64>,
    /// From the acceptance of a vector to its results.
    latency_cycles: u64,
    /// From one vector to the next.
    interval_cycles: f64,
    lanes: u32,
    /// In the steady state, of all lanes.
    exponentials_per_cycle: f64,
}

/// What straight pieces are made of.
#[derive(Serialize)]
struct Table {
    pieces: u32,
    table_bits: u32,
    /// Partial-product bits of the slope's multiplier, and of that by log2 e.
    slope_product_bits: u32,
    scale_product_bits: u32,
}

impl Table {
    fn of(exp: &ExpConfig) -> Option<Self> {
        let (widths, engine) = (exp.piece_widths(), exp.engine());
        (exp.form == ExpForm::Piecewise).then(|| Self {
            pieces: exp.pieces,
            table_bits: widths.table_bits(&engine),
            slope_product_bits: widths.slope_product_bits(&engine),
            scale_product_bits: widths.scale_product_bits(exp.input.width()),
        })
    }
}

/// What ends the power early costs: cutting off, or straight pieces.
fn approximation(exp: &ExpConfig) -> f64 {
    match exp.form {
        ExpForm::Piecewise => straightness(exp.pieces, exp.output_bits),
        _ => truncation(exp.resolved_bits(), exp.tail, exp.output_bits),
    }
}

pub(super) fn run(config: &Config, args: &CostArgs) -> Result<(), Failure> {
    let exp = &config.vu.exp;
    check(config)?;
    let spinner = progress::spinner("every input through the Verilated vector unit");
    let unit = VectorUnit::build(config)?;
    let codes: Vec<i32> = (0..1 << INPUT_BITS).collect();
    let zeros = vec![0; codes.len()];
    let batch = VectorBatch {
        op: VectorOp::new(OpCode::Exp),
        a: &codes,
        b: &zeros,
    };
    let run = unit.run(&[batch], &Stalls::NONE, 0)?;
    let reference = Reference::in_base(exp.input, exp.base)
        .map_err(|e| Failure::Inconclusive(e.to_string()))?;
    spinner.finish_and_clear();
    let error: ExpError = reference.measure(exp.output_bits, |u| {
        run.results.get(u as usize).copied().unwrap_or_default()
    });
    let lanes = config.vu.lanes as usize;
    let latency = |vector: usize| run.vectors.get(vector).map_or(0, |(from, to)| to - from);
    if let Some(path) = &args.table {
        let mut text = String::from("u_code,y_code,cycles\n");
        for (u, y) in codes.iter().zip(&run.results) {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{u},{y},{}", latency(*u as usize / lanes));
        }
        files::write(path, &text)?;
    }
    let (first, last) = (run.vectors.first(), run.vectors.last());
    let span = last.zip(first).map_or(0, |(last, first)| last.0 - first.0);
    let interval = span as f64 / (run.vectors.len().max(2) - 1) as f64;
    // With an early out it is an average.
    let interval = (interval * 1e3).round() / 1e3;
    let netlist = error_bound(config, OpCode::Exp)?;
    let engine = exp.engine();
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "cost",
        unit: "exp",
        configuration: config.hash(),
        inputs: codes.len(),
        form: exp.form,
        base: exp.base,
        pieces: Table::of(exp),
        early_out: exp.early_out,
        iterations: exp.iterations,
        tail: exp.tail,
        accumulator_bits: engine.accumulator_bits,
        constant_bits: engine.constant_bits,
        offset: engine.offset,
        output_bits: exp.output_bits,
        max_ulp: error.max_ulp,
        mean_ulp: error.mean,
        bias_ulp: error.bias,
        worst_code: error.worst_code,
        misrounded: error.misrounded,
        monotone: error.monotone,
        truncation_ulp: approximation(exp),
        budget_ulp: budget(exp),
        netlist_ulp: netlist.map(|bound| bound.ulp),
        netlist_dropped_ulp: netlist.map(|bound| bound.dropped),
        latency_cycles: latency(0),
        interval_cycles: interval,
        lanes: config.vu.lanes,
        exponentials_per_cycle: lanes as f64 / interval.max(1.0),
    };
    print(&report, args);
    if let Some(path) = &args.json {
        files::write_json(path, &report)?;
    }
    Ok(())
}

/// The sweep is of exp(-u) in the format of splats.
fn check(config: &Config) -> Result<(), Failure> {
    let exp = &config.vu.exp;
    let refuse = |field: &str, value: String, expected: &str| {
        Err(Failure::Usage(format!(
            "cost --study exp: `{field}` is {value}: expected {expected}"
        )))
    };
    if !config.vu.ops.contains(&OpCode::Exp) {
        return refuse("vu.ops", OpCode::list(&config.vu.ops), "\"exp\" among them");
    }
    if exp.form == ExpForm::Literal {
        let form = "literal".to_owned();
        return refuse("vu.exp.form", form, "a form that is right below 0");
    }
    if exp.output != ExpOutput::Alpha {
        let output = format!("{:?}", exp.output);
        return refuse("vu.exp.output", output, "the alpha configuration");
    }
    if exp.input != Format::unsigned(3, 13) {
        return refuse(
            "vu.exp.input",
            exp.input.to_string(),
            "U3.13, whose inputs the table lists",
        );
    }
    Ok(())
}

/// How powers are found, in words.
fn method(report: &Report) -> String {
    let tail = if report.tail { "on" } else { "off" };
    match (&report.pieces, report.form) {
        (Some(table), _) => {
            let base = match report.base {
                ExpBase::E => "exp(-u)",
                ExpBase::Two => "2^-u",
            };
            format!("{base} in {} straight pieces", table.pieces)
        }
        (None, ExpForm::Radix4) => {
            format!("radix 4, {} digits, tail {tail}", report.iterations)
        }
        (None, form) if form.plain().power_pipeline().turn() == 0 => {
            format!("form \"{}\"", form.name())
        }
        (None, _) if report.early_out => format!("n = {} at most, early out", report.iterations),
        (None, _) => format!("n = {}, tail {tail}", report.iterations),
    }
}

fn print(report: &Report, args: &CostArgs) {
    say!(
        "exponential, configuration {}: {}, widths {}/{}/{:+}, all {} inputs \
         through the Verilated unit",
        report.configuration,
        method(report),
        report.accumulator_bits,
        report.constant_bits,
        report.offset,
        report.inputs
    );
    if let Some(table) = &report.pieces {
        say!(
            "  table {} bits; multipliers of {} partial-product bits (slope) and {} (log2 e)",
            table.table_bits,
            table.slope_product_bits,
            table.scale_product_bits
        );
    }
    say!(
        "  error: at most {:.4} ulp (input code {}), {:.4} ulp on average, bias {:+.4} ulp \
         (measured RTL against 120 bits; 1 ulp = 2^-{})",
        report.max_ulp,
        report.worst_code,
        report.mean_ulp,
        report.bias_ulp,
        report.output_bits
    );
    // Of a form without a formula there is none.
    if report.budget_ulp.is_finite() {
        say!(
            "  budget: at most {:.4} ulp, of it {:.4} ulp for {} (formula)",
            report.budget_ulp,
            report.truncation_ulp,
            match report.form {
                ExpForm::Piecewise => "straight pieces",
                _ => "cutting off after n iterations",
            }
        );
    }
    if let Some(bound) = report.netlist_ulp {
        say!(
            "  bound: at most {bound:.4} ulp, of it {:.4} ulp of dropped bits (analysis of the netlist)",
            report.netlist_dropped_ulp.unwrap_or_default()
        );
    }
    say!(
        "  results not the nearest code: {}; monotone: {}",
        report.misrounded,
        if report.monotone { "yes" } else { "no" }
    );
    say!(
        "  latency {} cycles, a vector of {} every {} cycles: {:.2} exponentials a cycle \
         (measured RTL)",
        report.latency_cycles,
        report.lanes,
        report.interval_cycles,
        report.exponentials_per_cycle
    );
    if let Some(path) = &args.table {
        say!("  every input, result and latency: {}", path.display());
    }
}
