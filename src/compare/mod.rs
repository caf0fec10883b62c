//! `potamoi compare`: machines side by side.

pub(crate) mod picture;
mod rivals;
pub(crate) mod table;

use std::path::PathBuf;

use clap::Args;
use potamoi_base::outputs as files;
use potamoi_explore::Syntheses;
use potamoi_machines::machine::Section;
use potamoi_machines::{Comparison, Machine, Ratios, Workload};
use potamoi_system::system_model::System;
use schemars::JsonSchema;
use serde::Serialize;

use crate::args::ClockArgs;
use crate::charts;
use crate::failure::Failure;
use crate::given_syntheses::say_unused;
use crate::progress::{self, Shown};
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;
use crate::scene::{ManyScenes, left_open_of_files, say_not_checked};

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

#[derive(Debug, Args)]
#[command(mut_arg("width", |width| width.help(
    "Width of the picture [default: the scene's; with --rivals, of --scene alone]"
)))]
#[command(mut_arg("height", |height| height.help(
    "Height of the picture [default: in proportion to the width; with --rivals, of --scene alone]"
)))]
pub(crate) struct CompareArgs {
    /// Machines: presets, configuration files, files that `cost` and `explore` write; ratios are over
    /// the first
    #[arg(value_name = "MACHINE", required_unless_present = "rivals")]
    machines: Vec<String>,
    /// Compare with published accelerators, such as NeuRex and NGPC
    #[arg(long, conflicts_with_all = ["frames", "plot"])]
    rivals: bool,
    #[command(flatten)]
    scenes: ManyScenes,
    /// Description of the system as TOML, in which omitted fields have the paper's values; or the
    /// paper's system with another GPU, by name: xavier, xavier-15w, orin-nx, agx-orin and others
    /// [default: each machine's, or the paper's system]
    #[arg(long, value_name = "SYSTEM,...", value_delimiter = ',')]
    system: Vec<PathBuf>,
    /// Area, clock and energy of units, as written by `potamoi synth --json`
    /// [default: the built-in results and formulas]
    #[arg(
        long,
        value_name = "FILE,...",
        value_delimiter = ',',
        conflicts_with = "rivals"
    )]
    synth: Vec<PathBuf>,
    /// Number of frames on the camera path
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    #[command(flatten)]
    clock: ClockArgs,
    /// Write the results as CSV: a line of names, and one for each machine, case, setting, form or input
    /// that the command measures
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write a plot of the result as SVG
    #[arg(long, value_name = "FILE", value_parser = crate::charts::svg)]
    plot: Option<PathBuf>,
    #[command(flatten)]
    files: ReportFiles,
}

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "compare",
    version: FORMAT_VERSION,
    shape: shape::<Report<'_>>,
};

/// The report of `--rivals --json`.
pub(crate) const RIVALS: Published = Published {
    command: "compare --rivals",
    version: rivals::FORMAT_VERSION,
    shape: shape::<rivals::Report<'_>>,
};

#[derive(Serialize, JsonSchema)]
struct Report<'a> {
    format_version: u32,
    command: &'static str,
    #[serde(flatten)]
    found: &'a Comparison,
    /// Ratios over the first machine, of each scene's rows.
    ratios: Vec<Vec<Option<Ratios>>>,
    /// Items that scenes' files leave open.
    not_checked: Vec<String>,
}

pub(crate) fn run(args: &CompareArgs) -> Result<(), Failure> {
    args.files
        .prepare([&args.csv, &args.plot].map(Option::as_ref))?;
    if args.rivals {
        return rivals::run(args);
    }
    let syntheses = Syntheses::read(&args.synth)?;
    let machines = args.machines()?;
    let knowing = machines.into_iter().map(|own| own.knowing(&syntheses));
    let machines: Vec<Machine> = knowing.collect();
    let scenes = args.scenes.open()?;
    let workload = Workload {
        frames: args.frames,
        ..Workload::default()
    };
    let bar = progress::bar(0, "comparing");
    let found = Comparison::of(&machines, &scenes, &workload, &Shown(&bar))?;
    bar.finish_and_clear();
    table::print(&found);
    say_unused(&args.synth, &syntheses, machines);
    let not_checked = left_open_of_files();
    say_not_checked(&not_checked);
    if let Some(path) = &args.csv {
        let text = found.csv();
        let text = text.map_err(|error| Failure::Usage(format!("{}: {error}", path.display())))?;
        files::write(path, &text)?;
    }
    if let Some(path) = &args.plot {
        charts::write(path, &picture::spec(&found))?;
    }
    if args.files.are_asked() {
        let report = Report {
            format_version: FORMAT_VERSION,
            command: "compare",
            ratios: (found.scenes.iter().enumerate())
                .map(|(scene, rows)| {
                    (0..rows.len())
                        .map(|row| found.ratios(scene, row))
                        .collect()
                })
                .collect(),
            found: &found,
            not_checked,
        };
        args.files.write(&report)?;
    }
    Ok(())
}

impl CompareArgs {
    /// All machines, each in each system that it may be in.
    fn machines(&self) -> Result<Vec<Machine>, Failure> {
        self.machines_named(&self.machines)
    }

    /// As [`CompareArgs::machines`], of other names.
    fn machines_named(&self, names: &[String]) -> Result<Vec<Machine>, Failure> {
        let mut all = vec![];
        for given in names {
            let machine = self.at_clock(Machine::named(given)?)?;
            if let Some(note) = machine.note() {
                crate::stdout::remark(format_args!("{note}"));
            }
            let is_placed = machine.sections().contains(&Section::System);
            if is_placed && !self.system.is_empty() {
                crate::stdout::remark(format_args!(
                    "{given} has a [system] of its own, which --system does not change"
                ));
            }
            if is_placed || self.system.is_empty() {
                all.push(machine);
                continue;
            }
            for system in &self.system {
                let mut own = machine.clone().around(System::named(system)?);
                if self.system.len() > 1 {
                    own.name = format!("{}, {}", own.name, system.display());
                }
                all.push(own);
            }
        }
        Ok(all)
    }

    /// The machine at the assumed clock, if there is one.
    fn at_clock(&self, mut machine: Machine) -> Result<Machine, Failure> {
        match machine.hardware.take() {
            Some(own) => machine.hardware = Some(self.clock.chosen(own)?),
            None if self.clock.is_assumed() => {
                return Err(Failure::Usage(format!(
                    "--assume-clock: {} names no configuration, so that each scene has a preset of its \
                     own: add `preset` to it",
                    machine.name
                )));
            }
            None => {}
        }
        Ok(machine)
    }
}
