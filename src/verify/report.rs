//! Results of a verification, as JSON and as a table.

use crate::stdout::say;
use crate::tables;
use std::path::PathBuf;

use comfy_table::{CellAlignment, Table, presets};
use indicatif::HumanCount;
use potamoi_formats::config::Config;
use potamoi_rtl::EngineKind;
use potamoi_rtl::verify::{Failure as Found, GatherReport, Injection, SplatReport, VectorReport};
use schemars::JsonSchema;
use serde::Serialize;

use super::Level;

/// Version of the JSON report.
pub(super) const FORMAT_VERSION: u32 = 1;

#[derive(Serialize, JsonSchema)]
pub(super) struct Report<'a> {
    pub(super) format_version: u32,
    pub(super) command: &'static str,
    pub(super) scene: &'a str,
    pub(super) trace: Option<&'a PathBuf>,
    /// Folder of the Verilog; `null` for that of the configuration.
    pub(super) rtl: Option<&'a PathBuf>,
    pub(super) width: Option<u32>,
    pub(super) height: Option<u32>,
    /// Hash of the configuration, 12 hexadecimal digits.
    pub(super) configuration: String,
    pub(super) engine: EngineKind,
    pub(super) level: Level,
    pub(super) seed: u64,
    pub(super) inject: Option<Injection>,
    /// Differences; verification ends at the first.
    pub(super) mismatches: u64,
    /// Feature vectors compared.
    pub(super) samples: u64,
    /// Vectors of the vector unit compared.
    pub(super) vectors: u64,
    /// Cycles of the gathering unit from the first to the last issue, measured on RTL.
    pub(super) cycles: u64,
    /// Cycles of the gathering unit by the cycle model's closed form.
    pub(super) cycles_predicted: u64,
    pub(super) busy: u64,
    pub(super) stall_fifo: u64,
    pub(super) stall_mft: u64,
    pub(super) stall_rit: u64,
    /// Bank stalls of the feature-major organisation; 0 in others.
    pub(super) stall_bank: u64,
    pub(super) gathering_unit: &'a GatherReport,
    pub(super) vector_unit: &'a VectorReport,
    /// `null` where the configuration has no splat unit.
    pub(super) splat_unit: Option<&'a SplatReport>,
    pub(super) failure: Option<&'a Found>,
    /// Items outside the units, and items that a model's file leaves open.
    pub(super) not_checked: Vec<String>,
    pub(super) seconds: f64,
}

/// Prints the compared amounts; nothing for a failed run.
pub(super) fn print(report: &Report<'_>, config: &Config) {
    let of = match (report.trace, report.width.zip(report.height)) {
        (Some(trace), _) => format!("{} (trace of {})", trace.display(), report.scene),
        (None, Some((width, height))) => format!("{} at {width} x {height}", report.scene),
        (None, None) => report.scene.to_owned(),
    };
    say!(
        "{of}, configuration {}, engine {}, seed {}",
        report.configuration,
        report.engine,
        report.seed
    );
    if let Some(folder) = report.rtl {
        say!("the Verilog of {}", folder.display());
    }
    if report.failure.is_some() {
        return;
    }
    let mut table = Table::new();
    table.load_preset(presets::ASCII_BORDERS_ONLY_CONDENSED);
    table.set_header(["", "gathering unit", "vector unit", "unit", "origin"]);
    table.add_rows(rows(report, config));
    for column in 1..3 {
        if let Some(column) = table.column_mut(column) {
            column.set_cell_alignment(CellAlignment::Right);
        }
    }
    say!("{}", tables::fitted(&table, &[]));
    if let Some(splat) = report.splat_unit {
        print_splats(report, splat);
    }
}

/// Prints what was compared of the splat unit.
fn print_splats(report: &Report<'_>, splat: &SplatReport) {
    let count = |n: u64| HumanCount(n).to_string();
    let mut table = Table::new();
    table.load_preset(presets::ASCII_BORDERS_ONLY_CONDENSED);
    table.set_header(["", "splat unit", "unit", "origin"]);
    let measured = measured(report.engine);
    let (golden, model) = ("golden model", "cycle model");
    let rows = [
        (
            "compared, every bit",
            share(splat.pixels, splat.pixels_total),
            "pixels",
            golden,
        ),
        (
            "ray groups, each a job",
            share(splat.jobs, splat.jobs_total),
            "jobs",
            golden,
        ),
        (
            "records in tiles",
            count(splat.records),
            "records",
            measured,
        ),
        (
            "square sums, exponentials",
            [splat.square_sums, splat.exponentials]
                .map(count)
                .join(", "),
            "pairs",
            measured,
        ),
        (
            "drawn, stopped",
            [splat.drawn, splat.stopped].map(count).join(", "),
            "pairs",
            measured,
        ),
        (
            "cycles, streams ready",
            count(splat.cycles),
            "cycles",
            measured,
        ),
        (
            "compared, every cycle",
            count(splat.cycles_compared),
            "cycles",
            model,
        ),
        (
            "  under random stalls",
            count(splat.cycles_stalled),
            "cycles",
            model,
        ),
    ];
    for (name, value, unit, origin) in rows {
        table.add_row([name, &value, unit, origin]);
    }
    if let Some(column) = table.column_mut(1) {
        column.set_cell_alignment(CellAlignment::Right);
    }
    say!("{}", tables::fitted(&table, &[]));
}

/// Where counts of an engine come from.
const fn measured(engine: EngineKind) -> &'static str {
    match engine {
        EngineKind::Verilator | EngineKind::Icarus => "RTL",
        EngineKind::Interpreter => "netlist",
    }
}

/// A part of a whole, with its percentage.
fn share(part: u64, whole: u64) -> String {
    let count = |n: u64| HumanCount(n).to_string();
    let percent = 100.0 * part as f64 / whole.max(1) as f64;
    if part == whole {
        return format!("all {}", count(whole));
    }
    format!("{} of {} ({percent:.2} %)", count(part), count(whole))
}

/// Rows of the table: quantity, gathering unit, vector unit, unit of measure, and method.
fn rows(report: &Report<'_>, config: &Config) -> [[String; 5]; 9] {
    let measured = measured(report.engine);
    let (g, v) = (report.gathering_unit, report.vector_unit);
    let count = |n: u64| HumanCount(n).to_string();
    [
        [
            "compared, every bit".to_owned(),
            share(g.samples, g.samples_total),
            share(v.elements, v.elements_total),
            "vectors, elements".to_owned(),
            "golden model".to_owned(),
        ],
        [
            "MVoxels, vectors".to_owned(),
            share(g.mvoxels, g.mvoxels_total),
            count(v.vectors),
            format!("MVoxels, vectors of {} lanes", config.vu.lanes),
            "golden model".to_owned(),
        ],
        [
            "cycles, streams ready".to_owned(),
            count(g.cycles),
            count(v.cycles),
            "cycles".to_owned(),
            measured.to_owned(),
        ],
        [
            "predicted".to_owned(),
            count(g.cycles_predicted),
            count(v.cycles_predicted),
            "cycles".to_owned(),
            "cycle model".to_owned(),
        ],
        [
            "busy".to_owned(),
            count(g.busy),
            count(v.busy),
            "cycles".to_owned(),
            measured.to_owned(),
        ],
        [
            "stalls: FIFO, MFT, RIT, bank".to_owned(),
            [g.stall_fifo, g.stall_mft, g.stall_rit, g.stall_bank]
                .map(count)
                .join(", "),
            count(v.stall_out),
            "cycles".to_owned(),
            measured.to_owned(),
        ],
        [
            "first fill, all runs".to_owned(),
            format!("{} = {}", count(g.fill), count(g.fill_predicted)),
            String::new(),
            "cycles".to_owned(),
            format!("{measured}, model"),
        ],
        [
            "compared, every cycle".to_owned(),
            count(g.cycles_compared),
            count(v.cycles_compared),
            "cycles".to_owned(),
            "cycle model".to_owned(),
        ],
        [
            "  under random stalls".to_owned(),
            count(g.cycles_stalled),
            count(v.cycles_stalled),
            "cycles".to_owned(),
            "cycle model".to_owned(),
        ],
    ]
}
