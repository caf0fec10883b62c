//! `potamoi prove`: proofs of the checks in the emitted Verilog.

use clap::Args;
use potamoi_prove::{Options, Outcome, Proof, Tools, units};
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::Common;
use crate::failure::Failure;
use crate::progress;
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;
use crate::stdout::say;
use crate::tables;

#[derive(Debug, Args)]
pub(crate) struct ProveArgs {
    /// Length of the runs in which a property that is not proven is looked for
    #[arg(long, value_name = "CYCLES", default_value_t = 20,
        value_parser = clap::value_parser!(u32).range(4..=1000))]
    cycles: u32,
    /// Length of the runs in which cover points are looked for [default: not looked for]
    #[arg(long, value_name = "CYCLES", value_parser = clap::value_parser!(u32).range(1..=1000))]
    covers: Option<u32>,
    /// Prove of whole payloads what is else proven of their bit 0; takes minutes where they are wide
    #[arg(long)]
    all_bits: bool,
    #[command(flatten)]
    files: ReportFiles,
}

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "prove",
    version: FORMAT_VERSION,
    shape: shape::<Report>,
};

#[derive(Serialize, JsonSchema)]
struct Report {
    format_version: u32,
    command: &'static str,
    /// Hash of the configuration, 12 hexadecimal digits.
    configuration: String,
    yosys: String,
    yices: String,
    units: Vec<Proof>,
}

pub(crate) fn run(common: &Common, args: &ProveArgs) -> Result<(), Failure> {
    args.files.prepare([])?;
    let config = common.read_config()?;
    let tools = Tools::find()?;
    let options = Options {
        depth: args.cycles,
        cover: args.covers.unwrap_or(0),
    };
    let mut proofs = vec![];
    for mut unit in units(&config)? {
        unit.all_bits = args.all_bits;
        let spinner = progress::spinner(&format!("proving {}", unit.name));
        proofs.push(unit.prove(&tools, options)?);
        spinner.finish_and_clear();
    }
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "prove",
        configuration: config.hash(),
        yosys: tools.yosys,
        yices: tools.yices,
        units: proofs,
    };
    for proof in &report.units {
        print(proof);
    }
    args.files.write(&report)?;
    let failed = failed(&report.units);
    match failed.is_empty() {
        true => Ok(()),
        false => Err(Failure::check(format!(
            "not held by the Verilog: {}",
            failed.join(", ")
        ))),
    }
}

/// Properties with a counterexample.
fn failed(proofs: &[Proof]) -> Vec<String> {
    let all = proofs.iter().flat_map(|proof| {
        let failed = proof.properties.iter();
        let failed = failed.filter(|p| matches!(p.outcome, Outcome::Failed(_)));
        failed.map(|p| format!("{}.{}", proof.unit, p.name))
    });
    all.collect()
}

fn outcome(outcome: Outcome) -> [String; 3] {
    let (method, said, cycles) = match outcome {
        Outcome::Proven => ("induction", "proven", None),
        Outcome::Bounded(cycles) => ("all runs", "bounded", Some(cycles)),
        Outcome::Failed(cycle) => ("all runs", "FAILED", Some(cycle)),
        Outcome::Reached(cycle) => ("a run", "reached", Some(cycle)),
        Outcome::NotReached(cycles) => ("all runs", "not reached", Some(cycles)),
    };
    let cycles = cycles.map_or_else(|| "all".to_owned(), |n: u32| n.to_string());
    [method.to_owned(), said.to_owned(), cycles]
}

fn print(proof: &Proof) {
    say!(
        "{}: {:.1} s for the properties together, {:.1} s for the cover points",
        proof.unit,
        proof.seconds,
        proof.cover_seconds
    );
    let mut table = tables::lined(3, ["property", "method", "outcome", "cycles"]);
    let mut supporting = 0;
    for property in &proof.properties {
        if property.supports && property.outcome == Outcome::Proven {
            supporting += 1;
            continue;
        }
        let [method, said, cycles] = outcome(property.outcome);
        table.add_row([property.name.clone(), method, said, cycles]);
    }
    say!("{}", tables::fitted(&table, &[]));
    say!("with {supporting} invariants that support them");
    say!("abstractions: {}", proof.abstractions.join("; "));
    match proof.assumptions.is_empty() {
        true => say!("assumed: nothing"),
        false => say!("assumed: {}", proof.assumptions.join(" ")),
    }
}
