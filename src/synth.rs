//! `potamoi synth`: the units as cells of a library.

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use clap::{Args, ValueEnum};
use comfy_table::{CellAlignment, Table, presets};
use potamoi_sim::synth::{
    Cacti, Library, Made, Raw, SynthError, SynthReport, Tools, UnitKind, UnitReport,
    default_library, differences, scaling, synthesise,
};

use crate::common::Common;
use crate::failure::Failure;
use crate::files::{self, FileError};
use crate::progress;
use crate::say::say;

/// Differences that are printed; the rest is counted.
const SHOWN: usize = 20;

#[derive(Debug, Args)]
pub(crate) struct SynthArgs {
    /// Cell library, a Liberty file, plain or packed with gzip; that of the package
    /// qflow-tech-osu018 (180 nm) unless given
    #[arg(long, value_name = "FILE")]
    liberty: Option<PathBuf>,
    /// Which unit
    #[arg(long, value_enum, default_value_t = Units::All)]
    unit: Units,
    /// How many units at once
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=64))]
    jobs: u8,
    /// The library's node in nanometres, which no Liberty file says: figures are then
    /// scaled too
    #[arg(long, value_name = "NM")]
    node: Option<u32>,
    /// The node that figures are scaled to, in nanometres
    #[arg(long, value_name = "NM", default_value_t = 12)]
    scale_to: u32,
    /// A clock that each unit must reach before wires, in GHz: exit status 1 where it does not
    #[arg(long, value_name = "GHZ")]
    clock: Option<f64>,
    /// Compare with a report made earlier: exit status 4 where anything differs
    #[arg(long, value_name = "FILE")]
    compare: Option<PathBuf>,
    /// Folder for the netlists in cells
    #[arg(long, value_name = "DIR")]
    netlists: Option<PathBuf>,
    /// Report as JSON: parameters, units, origins
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Units {
    /// The gathering unit
    Gu,
    /// The vector unit
    Vu,
    /// Both
    All,
}

pub(crate) fn run(common: &Common, args: &SynthArgs) -> Result<(), Failure> {
    if let Some(clock) = args.clock.filter(|c| !(c.is_finite() && *c > 0.0)) {
        let expected = "expected a number of gigahertz above 0";
        return Err(Failure::Usage(format!("--clock {clock}: {expected}")));
    }
    if let Some(node) = args.node.filter(|n| scaling::logic(*n, args.scale_to).is_none()) {
        return Err(Failure::Usage(format!(
            "--node {node} --scale-to {}: no factors; known are {} nm",
            args.scale_to,
            scaling::known()
        )));
    }
    files::prepare([args.json.as_ref()])?;
    let config = common.read_config()?;
    let expected = args.compare.as_ref().map(read_report).transpose()?;
    let path = args.liberty.clone().map_or_else(default_library, Ok)?;
    let library = Library::read(&path)?;
    let tools = Tools::find()?;
    let cache = potamoi_verilated::default_cache_folder().map_err(SynthError::from)?;
    let cache = cache.with_file_name("synth");
    let units: &[_] = match args.unit {
        Units::Gu => &[UnitKind::Gathering],
        Units::Vu => &[UnitKind::Vector],
        Units::All => &[UnitKind::Gathering, UnitKind::Vector],
    };
    say!(
        "library {} of {} cells, {} V, {}; OpenSTA {}",
        library.name,
        library.cells.len(),
        library
            .volts
            .map_or_else(|| "?".to_owned(), |v| v.to_string()),
        tools.yosys,
        tools.opensta
    );
    let made = in_parallel(units, args.jobs.into(), |unit| {
        synthesise(&config, unit, &library, &tools, &cache)
    })?;
    for made in &made {
        print(made);
        if let Some(folder) = &args.netlists {
            let to = folder.join(format!("{}.netlist.v", made.report.unit));
            let text = std::fs::read_to_string(&made.netlist);
            let text = text.map_err(|e| FileError::new(&made.netlist, e))?;
            files::write(&to, &text)?;
            say!("netlist: {}", to.display());
        }
    }
    let reports: Vec<UnitReport> = made.into_iter().map(|m| m.report).collect();
    let slow = args
        .clock
        .and_then(|clock| reports.iter().find(|r| r.clock_ghz < clock));
    let slow = slow.map(|r| (r.unit.clone(), r.clock_ghz));
    let memories = match Cacti::find(&cache) {
        Ok(cacti) => Some(potamoi_sim::synth::model(&reports, &cacti)?),
        Err(missing) => {
            say!("\nmemories are not included: {missing}");
            None
        }
    };
    let raw = Raw {
        units: reports,
        memories,
    };
    let report = SynthReport::new(&config, &library, &tools, raw, args.node, args.scale_to);
    print_totals(&report);
    if let Some(path) = &args.json {
        files::write_json(path, &report)?;
    }
    if let (Some((unit, ghz)), Some(clock)) = (slow, args.clock) {
        return Err(Failure::Check(format!(
            "{unit} reaches {ghz:.3} GHz before wires, not {clock}: see its longest path"
        )));
    }
    match expected {
        Some((path, expected)) => compare(&report, &path, &expected),
        None => Ok(()),
    }
}

/// Does every unit, `jobs` at once; the first failure, in the units' order.
fn in_parallel<T: Send>(
    units: &[UnitKind],
    jobs: usize,
    make: impl Fn(UnitKind) -> Result<T, SynthError> + Sync,
) -> Result<Vec<T>, SynthError> {
    let bar = progress::bar(units.len() as u64, "units");
    let next = AtomicUsize::new(0);
    let done = Mutex::new((0..units.len()).map(|_| None).collect::<Vec<_>>());
    let work = || {
        while let Some(unit) = units.get(next.fetch_add(1, Ordering::Relaxed)) {
            bar.set_message(unit.top());
            let result = make(*unit);
            bar.inc(1);
            let at = units.iter().position(|u| u == unit).unwrap_or(0);
            done.lock().unwrap_or_else(PoisonError::into_inner)[at] = Some(result);
        }
    };
    std::thread::scope(|scope| {
        for _ in 0..jobs.min(units.len()) {
            scope.spawn(work);
        }
    });
    bar.finish_and_clear();
    let done = done.into_inner().unwrap_or_else(PoisonError::into_inner);
    done.into_iter().flatten().collect()
}

fn print(made: &Made) {
    let report = &made.report;
    say!(
        "\n{}{}: {} cells, {} of them flip-flops, {:.6} mm^2; {:.0} ps a cycle before wires \
         ({:.3} GHz)",
        report.unit,
        if made.is_cached {
            " (made earlier)"
        } else {
            ""
        },
        report.cells,
        report.flops,
        report.area_um2 * 1e-6,
        report.period_ps,
        report.clock_ghz
    );
    say!(
        "longest path: {} to {}, {} cells",
        report.path[0],
        report.path[1],
        report.path_cells
    );
    let mut table = Table::new();
    table.load_preset(presets::NOTHING);
    table.set_header([
        "module",
        "count",
        "cells of one",
        "flip-flops",
        "um^2 of one",
        "share",
    ]);
    for module in &report.modules {
        let share = module.count as f64 * module.area_um2 / report.area_um2;
        table.add_row([
            module.module.clone(),
            module.count.to_string(),
            module.cells.to_string(),
            module.flops.to_string(),
            format!("{:.1}", module.area_um2),
            format!("{:.1} %", 100.0 * share),
        ]);
    }
    right(&mut table);
    say!("{table}");
    for memory in &report.memories {
        say!(
            "memory {}: {} of {} x {} bit, {} write and {} read ports, not in the areas above",
            memory.module,
            memory.count,
            memory.words,
            memory.bits,
            memory.writes,
            memory.reads
        );
    }
    for memory in &report.flop_memories {
        say!(
            "memory {}: {} of {} x {} bit, flip-flops in the areas above: {}",
            memory.memory,
            memory.count,
            memory.words,
            memory.bits,
            memory.why
        );
    }
}

/// Memories, and everything at the other node.
fn print_totals(report: &SynthReport) {
    if let Some(memories) = &report.raw.memories {
        let origin = &memories.origin;
        say!(
            "\nmemories by {}, {} nm, {}, {} K:",
            origin.cacti,
            origin.node_nm,
            origin.transistors,
            origin.kelvin
        );
        let mut table = Table::new();
        table.load_preset(presets::NOTHING);
        table.set_header([
            "memory", "count", "words x bits", "ports", "um^2 of one", "mm^2", "pJ read",
            "pJ write", "mW leakage", "ps access", "ps cycle",
        ]);
        for own in &memories.macros {
            let (shape, figures) = (&own.shape, &own.figures);
            let ports = match shape.read_writes {
                0 => format!("{} W {} R", shape.writes, shape.reads),
                both => format!("{both} RW"),
            };
            table.add_row([
                own.memory.clone(),
                own.count.to_string(),
                format!("{} x {}", shape.words, shape.bits),
                ports,
                format!("{:.0}", figures.area_um2),
                format!("{:.5}", own.count as f64 * figures.area_um2 * 1e-6),
                format!("{:.3}", figures.read_pj),
                format!("{:.3}", figures.write_pj),
                format!("{:.4}", own.count as f64 * figures.leakage_mw),
                format!("{:.0}", figures.access_ps),
                format!("{:.0}", figures.cycle_ps),
            ]);
        }
        right(&mut table);
        say!("{table}");
    }
    let Some(scaled) = &report.scaled else { return };
    if let Some(logic) = &scaled.logic {
        say!("\nat {} nm, by {}:", scaled.node_nm, logic.factors.table);
        for unit in &logic.units {
            say!(
                "{}: {:.6} mm^2, {:.0} ps ({:.3} GHz) before wires",
                unit.unit,
                unit.area_um2 * 1e-6,
                unit.period_ps,
                unit.clock_ghz
            );
        }
    }
    if let (Some(own), Some(raw)) = (&scaled.memories, &report.raw.memories) {
        say!("\nat {} nm, by {}:", scaled.node_nm, own.factors.table);
        for (own, raw) in own.macros.iter().zip(&raw.macros) {
            let figures = &own.figures;
            say!(
                "{}: {} of {:.0} um^2, {:.5} mm^2; {:.3} pJ read, {:.3} pJ write; {:.0} ps cycle",
                own.memory,
                raw.count,
                figures.area_um2,
                raw.count as f64 * figures.area_um2 * 1e-6,
                figures.read_pj,
                figures.write_pj,
                figures.cycle_ps
            );
        }
    }
}

/// Numbers to the right of names.
fn right(table: &mut Table) {
    table
        .column_iter_mut()
        .skip(1)
        .for_each(|c| c.set_cell_alignment(CellAlignment::Right));
}

type Expected = (PathBuf, serde_json::Value);

fn read_report(path: &PathBuf) -> Result<Expected, Failure> {
    let wrong = |why: String| {
        let path = path.display();
        Failure::Usage(format!(
            "--compare {path}: {why}; name a report of `potamoi synth --json`"
        ))
    };
    SynthReport::read(path)?;
    let text = std::fs::read_to_string(path).map_err(|e| wrong(e.to_string()))?;
    let value = serde_json::from_str(&text).map_err(|e| wrong(e.to_string()))?;
    Ok((path.clone(), value))
}

fn compare(
    report: &SynthReport,
    path: &std::path::Path,
    expected: &serde_json::Value,
) -> Result<(), Failure> {
    let here = serde_json::to_value(report).unwrap_or_default();
    let found = differences(&here, expected);
    if found.is_empty() {
        say!("\nthe same as {}", path.display());
        return Ok(());
    }
    say!("\nnot the same as {}:", path.display());
    for line in found.iter().take(SHOWN) {
        say!("  {line}");
    }
    if found.len() > SHOWN {
        say!("  and {} more", found.len() - SHOWN);
    }
    Err(Failure::Inconclusive(format!(
        "{} figures or origins differ from {}",
        found.len(),
        path.display()
    )))
}
