//! `potamoi synth`: the units as cells of a library.

mod power;

use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use clap::{Args, ValueEnum};
use comfy_table::{CellAlignment, Table, presets};
use potamoi_sim::synth::{
    Library, Made, SynthError, SynthReport, Tools, UnitKind, UnitReport, default_library,
    differences, synthesise,
};

use crate::common::Common;
use crate::failure::Failure;
use crate::files::{self, FileError};
use crate::progress;
use crate::say::say;
use power::{PowerArgs, Scenes};

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
    /// A clock that each unit must reach before wires, in GHz: exit status 1 where it does not
    #[arg(long, value_name = "GHZ")]
    clock: Option<f64>,
    /// Compare with a report made earlier: exit status 4 where anything differs
    #[arg(long, value_name = "FILE")]
    compare: Option<PathBuf>,
    /// Folder for the netlists in cells
    #[arg(long, value_name = "DIR")]
    netlists: Option<PathBuf>,
    #[command(flatten)]
    power: PowerArgs,
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
    files::prepare([args.json.as_ref()])?;
    let config = common.read_config()?;
    let expected = args.compare.as_ref().map(read_report).transpose()?;
    let path = args.liberty.clone().map_or_else(default_library, Ok)?;
    let library = Library::read(&path)?;
    let units: &[_] = match args.unit {
        Units::Gu => &[UnitKind::Gathering],
        Units::Vu => &[UnitKind::Vector],
        Units::All => &[UnitKind::Gathering, UnitKind::Vector],
    };
    let scenes = Scenes::open(&args.power, units)?;
    let tools = Tools::find()?;
    let cache = potamoi_verilated::default_cache_folder().map_err(SynthError::from)?;
    let cache = cache.with_file_name("synth");
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
    let work = scenes.work(&config)?;
    let with = (&library, &tools, &work);
    let made = in_parallel(units, args.jobs.into(), |unit| {
        let mut made = synthesise(&config, unit, &library, &tools, &cache)?;
        args.power.add(&config, unit, &mut made, with, &cache)?;
        Ok::<_, Failure>(made)
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
    let report = SynthReport::new(&config, &library, &tools, reports);
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
    make: impl Fn(UnitKind) -> Result<T, Failure> + Sync,
) -> Result<Vec<T>, Failure> {
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
    table
        .column_iter_mut()
        .skip(1)
        .for_each(|c| c.set_cell_alignment(CellAlignment::Right));
    say!("{table}");
    for memory in &report.memories {
        say!(
            "memory {}: {} of {} x {} bit, {} write and {} read ports, not in the areas",
            memory.module,
            memory.count,
            memory.words,
            memory.bits,
            memory.writes,
            memory.reads
        );
    }
    if let Some(power) = &report.power {
        power::print(power);
    }
}

type Expected = (PathBuf, serde_json::Value);

fn read_report(path: &PathBuf) -> Result<Expected, Failure> {
    let wrong = |why: String| {
        let path = path.display();
        Failure::Usage(format!(
            "--compare {path}: {why}; name a report of `potamoi synth --json`"
        ))
    };
    let text = std::fs::read_to_string(path).map_err(|e| wrong(e.to_string()))?;
    serde_json::from_str::<SynthReport>(&text).map_err(|e| wrong(e.to_string()))?;
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
