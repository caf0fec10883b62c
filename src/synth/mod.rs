//! `potamoi synth`: synthesis of the units to a cell library, and on an FPGA.

mod fpga;
mod grid;
mod memories;
mod power;
mod print;

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use potamoi_base::outputs as files;
use potamoi_explore::synthesis::{
    Activity, ActivityScenes, Flow, compare_variants, in_parallel, missed_clock, without_memories,
};
use potamoi_formats::config::{Config, NO_SPLAT_UNIT};
use potamoi_synth::grid::{design, forms};
use potamoi_synth::{
    Cacti, FPGA_FORMAT_VERSION, FpgaReport, Library, Memories, REPORT_FORMAT_VERSION, Raw,
    SynthError, SynthReport, Tools, UnitKind, UnitReport, access_times, default_library,
    differences, scaling, with_memories,
};

use crate::args::Common;
use crate::failure::Failure;
use crate::progress::{self, Shown};
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;
use crate::stdout::say;
use power::PowerArgs;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "synth",
    version: REPORT_FORMAT_VERSION,
    shape: shape::<SynthReport>,
};

/// The report of `--fpga --json`.
pub(crate) const FPGA: Published = Published {
    command: "synth --fpga",
    version: FPGA_FORMAT_VERSION,
    shape: shape::<FpgaReport>,
};

#[derive(Debug, Args)]
pub(crate) struct SynthArgs {
    /// Cell library: a Liberty file, plain or packed with gzip [default: that of the package
    /// qflow-tech-osu018, 180 nm]
    #[arg(long, value_name = "FILE")]
    liberty: Option<PathBuf>,
    /// Hardware unit
    #[arg(long, value_enum, default_value_t = Units::All)]
    unit: Units,
    /// Number of units synthesised in parallel
    #[arg(long, value_name = "N", default_value_t = 2, value_parser = clap::value_parser!(u8).range(1..=64))]
    jobs: u8,
    /// Technology node of the library, which Liberty files do not state; figures are scaled from it
    /// [default: not scaled]
    #[arg(long, value_name = "NM")]
    node: Option<u32>,
    /// Technology node that figures are scaled to
    #[arg(long, value_name = "NM", default_value_t = 12)]
    scale_to: u32,
    /// Target clock of each unit before wires, with its memories' access times where --node and
    /// CACTI give them; a unit that misses it gives exit status 1, after the report is written
    /// [default: none]
    #[arg(long, value_name = "GHZ")]
    clock: Option<f64>,
    /// Earlier report to compare the units with; any difference gives exit status 4 [default: none]
    #[arg(long, value_name = "FILE")]
    compare: Option<PathBuf>,
    /// Write a comparison of organisations, table memories and exponentials as Markdown tables, of
    /// configurations of its own
    #[arg(long, value_name = "FILE", conflicts_with_all = ["unit", "json", "csv_dir", "compare", "clock", "netlists"])]
    report: Option<PathBuf>,
    /// Synthesise a grid of configurations of its own, to fit formulas for area, period and energy to
    #[arg(long, value_name = "FILE", conflicts_with_all = ["unit", "json", "csv_dir", "compare", "clock", "netlists", "report"])]
    grid: Option<PathBuf>,
    /// Synthesise the paper's vector unit with the exponentials that no formula covers (a final
    /// multiply, two bits per step, straight pieces, other widths)
    #[arg(long, value_name = "FILE", conflicts_with_all = ["unit", "json", "csv_dir", "compare", "clock", "netlists", "report", "grid"])]
    forms: Option<PathBuf>,
    /// Ask CACTI about the memories of units and buffers over the usual values of their fields, for areas of
    /// units that were not synthesised
    #[arg(long, value_name = "FILE", conflicts_with_all = ["unit", "liberty", "json", "csv_dir", "compare", "clock", "netlists", "report", "grid", "forms", "fpga"])]
    memories: Option<PathBuf>,
    /// FPGA family to place and route for, with Yosys and nextpnr [default: cells of the library]
    #[arg(long, value_name = "FAMILY", conflicts_with_all = ["liberty", "node", "clock", "compare", "netlists", "report", "grid", "forms"])]
    fpga: Option<Family>,
    /// Seed of the pseudo-random numbers; equal seeds give equal results
    #[arg(long, value_name = "N", default_value_t = 1, requires = "fpga")]
    seed: u32,
    /// Folder for the gate-level netlists
    #[arg(long, value_name = "DIR")]
    netlists: Option<PathBuf>,
    #[command(flatten)]
    power: PowerArgs,
    #[command(flatten)]
    files: ReportFiles,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
pub(crate) enum Units {
    /// The gathering unit
    Gu,
    /// The vector unit
    Vu,
    /// A multiply-accumulate unit of the array, the same in every configuration
    Mac,
    /// The splat unit, of a configuration with a table [su]
    Su,
    /// The gathering and the vector unit, that of the array, and the splat unit of a configuration
    /// with one
    All,
}

#[derive(Debug, Clone, Copy, ValueEnum)]
enum Family {
    /// Lattice ECP5, its largest device
    Ecp5,
}

impl Units {
    /// Units of the configuration, of those chosen: formulas and placement are of these alone.
    pub(crate) fn of_configuration(self) -> Result<&'static [UnitKind], Failure> {
        match self {
            Self::Mac => Err(Failure::Usage(
                "--unit mac: the array's unit is no part of a configuration; potamoi synth --unit \
                 mac synthesises it"
                    .to_owned(),
            )),
            Self::Su => Err(Failure::Usage(
                "--unit su: no formulas and no placement of the splat unit; potamoi synth --unit su \
                 synthesises it"
                    .to_owned(),
            )),
            Self::All => Ok(&[UnitKind::Gathering, UnitKind::Vector]),
            Self::Gu => Ok(&[UnitKind::Gathering]),
            Self::Vu => Ok(&[UnitKind::Vector]),
        }
    }

    /// The units to synthesise of a configuration.
    pub(crate) const fn kinds(self, config: &Config) -> &'static [UnitKind] {
        match self {
            Self::Gu => &[UnitKind::Gathering],
            Self::Vu => &[UnitKind::Vector],
            Self::Mac => &[UnitKind::ArrayMac],
            Self::Su => &[UnitKind::Splat],
            Self::All if config.su.is_some() => &UnitKind::WITH_SPLAT_UNIT,
            Self::All => &UnitKind::ALL,
        }
    }
}

pub(crate) fn run(common: &Common, args: &SynthArgs) -> Result<(), Failure> {
    check(args)?;
    let written = [&args.report, &args.grid, &args.forms, &args.memories];
    args.files.prepare(written.map(Option::as_ref))?;
    let own = [
        ("--report", &args.report),
        ("--grid", &args.grid),
        ("--forms", &args.forms),
        ("--memories", &args.memories),
    ];
    if let Some((flag, _)) = own.iter().find(|(_, file)| file.is_some()) {
        common.refuse_config(&format!("synth {flag}"))?;
    }
    let config = common.read_config()?;
    let cache = potamoi_verilated::cache::folder("synth").map_err(SynthError::from)?;
    if let Some(path) = &args.memories {
        return memories::run(&cache, path);
    }
    if let Some(Family::Ecp5) = args.fpga {
        return fpga::run(&config, args, &cache);
    }
    let expected = args.compare.as_deref().map(read_report).transpose()?;
    let path = args.liberty.clone().map_or_else(default_library, Ok)?;
    let library = Library::read(&path)?;
    let activity = args.power.activity(args.unit)?;
    if matches!(args.unit, Units::Su) && config.su.is_none() {
        return Err(Failure::Usage(format!("--unit su: {NO_SPLAT_UNIT}")));
    }
    let scenes = ActivityScenes::open(&activity, args.unit.kinds(&config))?;
    scenes.scenes().for_each(crate::scene::note);
    let tools = Tools::find()?;
    print_library(&library, &tools);
    let flow = Flow {
        library: &library,
        tools: &tools,
        cache: &cache,
    };
    if let Some(path) = &args.report {
        return compare_organisations(args, &flow, path);
    }
    if let Some(path) = &args.grid {
        return grid::run(args, &flow, "--grid", &design(), path);
    }
    if let Some(path) = &args.forms {
        return grid::run(args, &flow, "--forms", &forms(), path);
    }
    let (reports, memories) = units(&config, args, &flow, (&activity, scenes))?;
    let missed = args.clock.and_then(|clock| missed_clock(&reports, clock));
    let note = args.clock.and_then(|_| without_memories(&reports));
    let raw = Raw {
        units: reports,
        memories,
    };
    let report = SynthReport::new(&config, &library, &tools, raw, args.node, args.scale_to);
    print::totals(&report);
    args.files.write(&report)?;
    if let Some(note) = note {
        say!("\n{note}");
    }
    if let Some(missed) = missed {
        return Err(Failure::check(missed));
    }
    match expected {
        Some((path, expected)) => compare(&report, &path, expected, args.unit.kinds(&config)),
        None => Ok(()),
    }
}

/// `--report`: organisations and exponentials side by side.
fn compare_organisations(args: &SynthArgs, flow: &Flow<'_>, path: &Path) -> Result<(), Failure> {
    let bar = progress::bar(0, "steps");
    let nodes = (args.node, args.scale_to);
    let text = compare_variants(flow, args.jobs.into(), nodes, &Shown(&bar));
    bar.finish_and_clear();
    let text = text?;
    files::write(path, &text)?;
    say!("{}", text.trim_end());
    say!("\nreport: {}", path.display());
    Ok(())
}

/// Refuses a clock or nodes that are none.
fn check(args: &SynthArgs) -> Result<(), Failure> {
    if let Some(clock) = args.clock.filter(|c| !(c.is_finite() && *c > 0.0)) {
        let expected = "expected a number of gigahertz above 0";
        return Err(Failure::Usage(format!("--clock {clock}: {expected}")));
    }
    if let Some(node) = args
        .node
        .filter(|n| scaling::logic(*n, args.scale_to).is_none())
    {
        return Err(Failure::Usage(format!(
            "--node {node} --scale-to {}: no factors; known are {} nm",
            args.scale_to,
            scaling::known()
        )));
    }
    Ok(())
}

fn print_library(library: &Library, tools: &Tools) {
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
    for assumed in &library.assumed {
        say!("note: {assumed}");
    }
}

/// The units, with power, and their memories where CACTI is there.
fn units(
    config: &Config,
    args: &SynthArgs,
    flow: &Flow<'_>,
    (activity, scenes): (&Activity, ActivityScenes),
) -> Result<(Vec<UnitReport>, Option<Memories>), Failure> {
    let spinner = progress::spinner("rendering the work");
    let work = scenes.work(config)?;
    spinner.finish_and_clear();
    let (jobs, steps) = (args.jobs.into(), activity.steps());
    let bar = progress::bar(0, "steps");
    let made = in_parallel(
        args.unit.kinds(config),
        jobs,
        steps,
        &Shown(&bar),
        |unit, step| {
            let mut made = flow.synthesise(config, *unit, step)?;
            activity.add((config, *unit), &mut made, &work, flow, step)?;
            Ok::<_, Failure>(made)
        },
    );
    bar.finish_and_clear();
    let made = made?;
    for made in &made {
        print::unit(made);
        if let Some(folder) = &args.netlists {
            let to = folder.join(format!("{}.netlist.v", made.report.unit));
            files::write(&to, &made.netlist)?;
            say!("netlist: {}", to.display());
        }
    }
    let mut reports: Vec<UnitReport> = made.iter().map(|m| m.report.clone()).collect();
    let memories = match Cacti::find(flow.cache) {
        Ok(cacti) => Some(potamoi_synth::model(&reports, &cacti)?),
        Err(missing) => {
            say!("\nmemories are not included: {missing}");
            None
        }
    };
    if let (Some(memories), Some(node)) = (&memories, args.node) {
        let units = args.unit.kinds(config).iter().zip(&made);
        for (report, own) in reports.iter_mut().zip(units) {
            let access = access_times(memories, &report.unit, node, args.scale_to);
            let timed = access.map(|access| {
                let (unit, made) = own;
                with_memories(
                    config,
                    (*unit, made),
                    access,
                    flow.library,
                    flow.tools,
                    flow.cache,
                )
            });
            report.with_memories = timed.transpose()?;
        }
    }
    Ok((reports, memories))
}

type Expected = (PathBuf, SynthReport);

fn read_report(path: &Path) -> Result<Expected, Failure> {
    let report = SynthReport::read(path);
    let report = report.map_err(|e| Failure::Usage(format!("--compare {e}")))?;
    Ok((path.to_owned(), report))
}

/// Compares with those units of an earlier report that were made now.
fn compare(
    report: &SynthReport,
    path: &Path,
    expected: SynthReport,
    units: &[UnitKind],
) -> Result<(), Failure> {
    let (lines, found) = compared(report, path, expected, units);
    for line in lines {
        say!("{line}");
    }
    match found {
        0 => Ok(()),
        found => Err(Failure::inconclusive(format!(
            "{found} figures or origins differ from {}",
            path.display()
        ))),
    }
}

/// What is printed of a comparison, and how many differences there are.
fn compared(
    report: &SynthReport,
    path: &Path,
    mut expected: SynthReport,
    units: &[UnitKind],
) -> (Vec<String>, usize) {
    let left_out = expected.keep(units);
    let value = |report: &SynthReport| {
        let mut own = serde_json::to_value(report).unwrap_or_default();
        // Its hash stands beside it in files of all programs.
        if let Some(keys) = own.as_object_mut() {
            keys.remove("configuration_toml");
        }
        own
    };
    let found = differences(&value(report), &value(&expected));
    let not = if found.is_empty() { "" } else { "not " };
    let mut lines = vec![format!("\n{not}the same as {}", path.display())];
    let skipped = left_out.iter();
    lines.extend(
        skipped.map(|u| format!("  {u} is in the file and was not synthesised: not compared")),
    );
    lines.extend(found.iter().map(|line| format!("  {line}")));
    (lines, found.len())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::process::ExitCode;

    const PAPER: &str = include_str!("../../synth/paper-asap7.json");
    const BOTH: [UnitKind; 3] = UnitKind::ALL;

    fn read(text: &str) -> SynthReport {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("r.json");
        std::fs::write(&path, text).unwrap();
        read_report(&path).unwrap().1
    }

    /// The paper's report against itself, and with one figure changed: how many differ is
    /// exit status 4, and which is printed.
    #[test]
    fn one_other_figure_is_named_and_no_pass() {
        let path = Path::new("old.json");
        let own = read(PAPER);
        let same = compared(&own, path, own.clone(), &BOTH);
        assert_eq!(same, (vec!["\nthe same as old.json".to_owned()], 0));
        compare(&own, path, own.clone(), &BOTH).unwrap();

        let buffers = own.raw.units[0].buffers;
        let [from, to] = [buffers, buffers + 1].map(|n| format!("\"buffers\": {n},"));
        assert_eq!(PAPER.matches(&from).count(), 1);
        let other = read(&PAPER.replace(&from, &to));
        let (lines, found) = compared(&own, path, other.clone(), &BOTH);
        assert_eq!(found, 1);
        assert_eq!(
            lines,
            [
                "\nnot the same as old.json".to_owned(),
                format!(
                    "  raw.units[0].buffers: {buffers}, expected {}",
                    buffers + 1
                ),
            ]
        );
        let failure = compare(&own, path, other.clone(), &BOTH).unwrap_err();
        assert_eq!(
            failure.to_string(),
            "1 figures or origins differ from old.json"
        );
        assert_eq!(failure.exit_code(), ExitCode::from(4));

        // Of the vector unit alone nothing differs, and the other one is said to be left out.
        let mut vector = own;
        vector.keep(&BOTH[1..2]);
        let (lines, found) = compared(&vector, path, other, &BOTH[1..2]);
        assert_eq!(found, 0, "{lines:?}");
        assert!(lines[1].starts_with("  gathering_unit is in the file"));
    }
}
