//! `potamoi cost`: the cost of accuracy.

mod answers;
mod exponential;
mod methods;
pub(crate) mod pictures;
mod scene;
mod tables;

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use potamoi_explore::accuracy::Price;

use crate::args::{ClockArgs, Common};
use crate::failure::Failure;
use crate::published::{Published, one_of_three};
use crate::report_files::ReportFiles;
use crate::scene::SceneArgs;

/// Version of the JSON reports.
const FORMAT_VERSION: u32 = 3;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "cost",
    version: FORMAT_VERSION,
    shape: one_of_three::<scene::Report<'_>, exponential::Report<'_>, methods::Report<'_>>,
};

#[derive(Debug, Args)]
#[command(mut_arg("width", |width| width.help("Width of the picture [default: 128]")))]
pub(crate) struct CostArgs {
    /// Study of one part: the exponential alone, or methods of computing it [default: every knob of a scene's frame]
    #[arg(
        long,
        value_enum,
        conflicts_with_all = [
            "scene", "camera", "camera_index", "width", "height", "force", "without", "frames"
        ]
    )]
    study: Option<Study>,
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    clock: ClockArgs,
    /// Knobs to vary [default: all knobs of the scene]
    #[arg(
        long,
        value_name = "NAME,...",
        value_delimiter = ',',
        conflicts_with = "study"
    )]
    knobs: Vec<String>,
    /// Number of frames on the camera path
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(2..))]
    frames: u32,
    /// Search for the cheapest configuration that reaches this PSNR to the ground truth (to the
    /// converged picture where there is none), and verify its Verilog [default: no search]
    #[arg(long, value_name = "DB", group = "goal", conflicts_with_all = ["study", "budget_ms"])]
    target_psnr: Option<f64>,
    /// Search for the best quality within this time per frame, and verify its Verilog [default: no
    /// search]
    #[arg(long, value_name = "MS", group = "goal", conflicts_with = "study")]
    budget_ms: Option<f64>,
    /// Quantity that a search minimises; settings for which it is unknown are skipped
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = By::Time, requires = "target_psnr")]
    by: By,
    /// File for the machine that a search finds: its configuration, with [system], [render] and [path]
    #[arg(
        long,
        value_name = "FILE",
        default_value = "found.toml",
        requires = "goal"
    )]
    found: PathBuf,
    /// Area, clock and energy of units, as written by `potamoi synth --json`
    /// [default: the built-in results and formulas]
    #[arg(long, value_name = "FILE", conflicts_with = "study")]
    synth: Option<PathBuf>,
    /// Compare cycles and time of a frame by formulas, by cycle models and by the Verilated units,
    /// each with its error and wall time
    #[arg(long, conflicts_with = "study")]
    ladder: bool,
    /// Write the results as CSV: a line of names, and one for each machine, case, setting, form or input
    /// that the command measures
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Write the prices of `--study methods` as CSV: one line for each exponential by itself
    #[arg(long, value_name = "FILE")]
    prices: Option<PathBuf>,
    /// Write a plot of the result as SVG
    #[arg(long, value_name = "FILE", value_parser = crate::charts::svg)]
    plot: Option<PathBuf>,
    #[command(flatten)]
    files: ReportFiles,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Study {
    /// The vector unit's exponential, over all 65,536 inputs
    Exp,
    /// Forms of the exponential over all inputs, beside methods of other accelerators
    Methods,
}

/// Objective of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum By {
    /// Time of a frame
    Time,
    /// Energy of a frame in the whole system
    Energy,
    /// Cell area of both units
    Area,
}

impl From<By> for Price {
    fn from(by: By) -> Self {
        match by {
            By::Time => Self::Time,
            By::Energy => Self::Energy,
            By::Area => Self::Area,
        }
    }
}

pub(crate) fn run(common: &Common, args: &CostArgs) -> Result<(), Failure> {
    let searches = args.target_psnr.is_some() || args.budget_ms.is_some();
    let written = [&args.csv, &args.prices, &args.plot].map(Option::as_ref);
    let found = searches.then_some(&args.found);
    args.files.prepare(written.into_iter().chain([found]))?;
    for (name, goal) in [
        ("--target-psnr", args.target_psnr),
        ("--budget-ms", args.budget_ms),
    ] {
        if let Some(value) = goal.filter(|value| !(value.is_finite() && *value > 0.0)) {
            return Err(Failure::Usage(format!(
                "{name} {value}: expected a positive number"
            )));
        }
    }
    if args.prices.is_some() && args.study != Some(Study::Methods) {
        return Err(Failure::Usage(
            "--prices: expected with --study methods, which has the exponentials by themselves"
                .to_owned(),
        ));
    }
    match args.study {
        Some(Study::Exp) if args.plot.is_some() => Err(Failure::Usage(
            "--plot: expected without --study exp, which has one point; --study methods has many"
                .to_owned(),
        )),
        Some(Study::Methods) if common.config.is_some() => Err(Failure::Usage(
            "--config: expected without --study methods, whose forms are its own; --study exp measures \
             that of a configuration"
                .to_owned(),
        )),
        Some(Study::Methods) => methods::run(args),
        Some(Study::Exp) => exponential::run(&common.read_config()?, args),
        None => scene::run(common, args),
    }
}
