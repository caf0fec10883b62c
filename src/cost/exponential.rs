//! `potamoi cost --study exp`: every input of the exponential through the Verilated unit.

use potamoi_base::outputs as files;
use potamoi_explore::ExploreError;
use potamoi_explore::exponential::{ExponentialReport, ExponentialSweep};
use potamoi_formats::config::{Config, ExpBase, ExpForm};
use schemars::JsonSchema;
use serde::Serialize;

use super::{CostArgs, FORMAT_VERSION};
use crate::failure::Failure;
use crate::progress;
use crate::stdout::{prose, say};

#[derive(Serialize, JsonSchema)]
pub(super) struct Report<'a> {
    format_version: u32,
    command: &'static str,
    unit: &'static str,
    #[serde(flatten)]
    found: &'a ExponentialReport,
}

pub(super) fn run(config: &Config, args: &CostArgs) -> Result<(), Failure> {
    let spinner = progress::spinner("every input through the Verilated vector unit");
    let sweep = ExponentialSweep::run(config).map_err(|error| match error {
        ExploreError::Refused(why) => Failure::Usage(format!("cost --study exp: {why}")),
        error => error.into(),
    })?;
    spinner.finish_and_clear();
    if let Some(path) = &args.csv {
        files::write(path, &sweep.csv())?;
    }
    print(&sweep.report, args);
    if args.files.are_asked() {
        let report = Report {
            format_version: FORMAT_VERSION,
            command: "cost",
            unit: "exp",
            found: &sweep.report,
        };
        args.files.write(&report)?;
    }
    Ok(())
}

/// Description of the algorithm.
fn method(report: &ExponentialReport) -> String {
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

fn print(report: &ExponentialReport, args: &CostArgs) {
    prose!(
        0,
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
        prose!(
            2,
            "table {} bits; multipliers of {} partial-product bits (slope) and {} (log2 e)",
            table.table_bits,
            table.slope_product_bits,
            table.scale_product_bits
        );
    }
    prose!(
        2,
        "error: at most {:.4} ulp (input code {}), {:.4} ulp on average, {:.4} ulp rms, bias \
         {:+.4} ulp (measured RTL against 120 bits; 1 ulp = 2^-{})",
        report.max_ulp,
        report.worst_code,
        report.mean_ulp,
        report.rms_ulp,
        report.bias_ulp,
        report.output_bits
    );
    // Of a form without a formula there is none.
    if report.budget_ulp.is_finite() {
        prose!(
            2,
            "budget: at most {:.4} ulp, {:.4} ulp of which for {} (formula)",
            report.budget_ulp,
            report.truncation_ulp,
            match report.form {
                ExpForm::Piecewise => "straight pieces",
                _ => "truncation after n iterations",
            }
        );
    }
    if let Some(bound) = report.netlist_ulp {
        prose!(
            2,
            "bound: at most {bound:.4} ulp, {:.4} ulp of which for dropped bits (analysis of the \
             netlist)",
            report.netlist_dropped_ulp.unwrap_or_default()
        );
    }
    prose!(
        2,
        "results not the nearest code: {}; monotone: {}",
        report.misrounded,
        if report.monotone { "yes" } else { "no" }
    );
    prose!(
        2,
        "latency {} cycles, a vector of {} every {} cycles: {:.2} exponentials a cycle \
         (measured RTL)",
        report.latency_cycles,
        report.lanes,
        report.interval_cycles,
        report.exponentials_per_cycle
    );
    if let Some(path) = &args.csv {
        say!("  every input, result and latency: {}", path.display());
    }
}
