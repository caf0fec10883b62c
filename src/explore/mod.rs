//! `potamoi explore`: the best machine of a space, within limits, proven by its Verilog.

mod table;

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use potamoi_explore::Syntheses;
use potamoi_explore::accuracy::Proof;
use potamoi_machines::cells::COLUMNS;
use potamoi_machines::search::{Goal, Objective, Search, Searched, Tried};
use potamoi_machines::{Axis, Comparison, Fidelity, Machine, Space, SpaceError, Workload};
use potamoi_scene::Scene;
use schemars::JsonSchema;
use serde::Serialize;

use crate::compare;
use crate::failure::Failure;
use crate::found::Found;
use crate::given_syntheses::say_unused;
use crate::progress::{self, Shown};
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;
use crate::scene::{ManyScenes, left_open_of_files, say_not_checked};
use crate::stdout::{prose, say};

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "explore",
    version: FORMAT_VERSION,
    shape: shape::<Report<'_>>,
};
/// Field of the clock, and its short name.
const CLOCK: [&str; 2] = ["clock", "clock_ghz"];

/// Fields of the system that the model assumes.
const ASSUMED: [&str; 7] = [
    "system.dma_descriptor_bytes",
    "system.gpu.idle_watts",
    "system.gpu.shares_memory",
    "system.interconnect_over_memory",
    "system.interconnect_pj_per_byte",
    "system.remote.idle_watts",
    "system.wire_margin",
];

#[derive(Debug, Args)]
pub(crate) struct ExploreArgs {
    /// Machine whose fields vary: a preset, or a file
    #[arg(value_name = "MACHINE", default_value = "paper")]
    machine: String,
    #[command(flatten)]
    scenes: ManyScenes,
    /// Field with its values, such as vu.lanes=12,24,48, gu.ports=1..4:*2, system.memory_channels=1,2,4,
    /// render.step=0.25..1:+0.25, path.window=4,8, clock=reached,1.0, or a list in TOML; several flags
    #[arg(long, value_name = "FIELD=VALUES", required = true, value_parser = axis)]
    vary: Vec<Axis>,
    /// Figure to make best; with several scenes its geometric mean
    #[arg(long, value_enum, value_name = "WHAT", default_value_t = What::Fps)]
    objective: What,
    /// Most area of the accelerator with array and buffers, in mm^2 at 12 nm [default: no limit]
    #[arg(long, value_name = "MM2")]
    max_area: Option<f64>,
    /// Least PSNR on every scene [default: no limit]
    #[arg(long, value_name = "DB")]
    min_psnr: Option<f64>,
    /// Least frame rate on every scene [default: no limit]
    #[arg(long, value_name = "FPS")]
    min_fps: Option<f64>,
    /// Most energy of a frame on every scene [default: no limit]
    #[arg(long, value_name = "MJ")]
    max_mj: Option<f64>,
    /// Area, clock and energy of units, as written by `potamoi synth --json`
    /// [default: the built-in results and formulas]
    #[arg(long, value_name = "FILE,...", value_delimiter = ',')]
    synth: Vec<PathBuf>,
    /// Most points to try; a space with no more points is tried whole
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = clap::value_parser!(u32).range(1..))]
    budget: u32,
    /// Seed of the pseudo-random numbers; equal seeds give equal results
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// Method of times and energies; the machine that is found is modelled by its schedule in any case
    #[arg(long, value_enum, default_value_t = By::Schedule)]
    fidelity: By,
    /// Number of frames on the camera path
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Folder for the rows of all points; the same command goes on where it was interrupted
    #[arg(long, value_name = "DIR", default_value = "out/explore")]
    work_dir: PathBuf,
    /// File for the machine that a search finds: its configuration, with [system], [render] and [path]
    #[arg(long, value_name = "FILE", default_value = "found.toml")]
    found: PathBuf,
    #[command(flatten)]
    files: ReportFiles,
}

/// Objective of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum What {
    /// Frames a second
    Fps,
    /// Energy of a frame in the whole system
    Energy,
    /// Energy of a frame times its time
    Edp,
    /// Area of the accelerator
    Area,
}

impl From<What> for Objective {
    fn from(what: What) -> Self {
        match what {
            What::Fps => Self::Rate,
            What::Energy => Self::Energy,
            What::Edp => Self::EnergyDelay,
            What::Area => Self::Area,
        }
    }
}

/// Method of times and energies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum By {
    /// The largest demand of a frame on any resource: a bound, some ten times faster
    Demand,
    /// A schedule of the frames' blocks, with cycles by the cycle models
    Schedule,
}

impl From<By> for Fidelity {
    fn from(by: By) -> Self {
        match by {
            By::Demand => Self::Demand,
            By::Schedule => Self::Schedule,
        }
    }
}

fn axis(text: &str) -> Result<Axis, String> {
    let mut own = Axis::parse(text)?;
    let [short, field] = CLOCK;
    for name in own.fields.iter_mut().filter(|name| *name == short) {
        *name = field.to_owned();
    }
    Ok(own)
}

#[derive(Serialize, JsonSchema)]
struct Report<'a> {
    format_version: u32,
    command: &'static str,
    workload: &'a Workload,
    goal: &'a Goal,
    seed: u64,
    columns: Vec<&'static str>,
    #[serde(flatten)]
    searched: &'a Searched,
    /// What was compared on each scene, without a mismatch in any bit or cycle; none where no machine
    /// keeps the limits.
    proofs: Vec<Compared>,
    /// Items that scenes' files leave open.
    not_checked: Vec<String>,
}

/// Feature vectors, elements and pixels that were compared on a scene, each beside those of the frame.
#[derive(Serialize, JsonSchema)]
struct Compared {
    scene: String,
    vectors: [u64; 2],
    elements: [u64; 2],
    pixels: [u64; 2],
}

pub(crate) fn run(args: &ExploreArgs) -> Result<(), Failure> {
    args.files.prepare([Some(&args.found)])?;
    let goal = args.goal()?;
    let syntheses = Syntheses::read(&args.synth)?;
    let base = Machine::named(&args.machine)?.knowing(&syntheses);
    let space = Space::new(base, args.vary.clone()).map_err(usage)?;
    if let Some(error) = space.without_points() {
        return Err(usage(error.into()));
    }
    for field in args.vary.iter().flat_map(|axis| &axis.fields) {
        if ASSUMED.contains(&field.as_str()) {
            crate::stdout::remark(format_args!(
                "{field} is an assumption of the model, not a choice of a machine: what it gains is not built"
            ));
        }
    }
    let scenes = args.scenes.open()?;
    space.check_on(&scenes).map_err(usage)?;
    let workload = Workload {
        frames: args.frames,
        fidelity: args.fidelity.into(),
        ..Workload::default()
    };
    let search = Search {
        space: &space,
        scenes: &scenes,
        goal,
        workload,
        budget: args.budget as usize,
        seed: args.seed,
    };
    let bar = progress::bar(0, "exploring");
    let searched = search.run(&args.work_dir, &Shown(&bar))?;
    bar.finish_and_clear();
    table::settings(&searched);
    beside_base(&search, &searched);
    table::front(&searched, &goal);
    table::by_schedule(&searched);
    table::above_reached_clock(&searched, &goal);
    table::guessed_clock(&searched);
    table::unknown(&searched);
    table::refused(&searched);
    let machines = searched.tried().filter_map(|own| search.machine(own).ok());
    say_unused(&args.synth, &syntheses, machines.collect());
    table::beside_random(&searched, &goal);
    let ended = match searched.found() {
        None => Err(Failure::inconclusive(nothing_found(&args.found, &searched))),
        Some(found) if !found.is_better(searched.judged_base()) => {
            Err(Failure::inconclusive(format!(
                "nothing that was tried is better than {}, which keeps the limits{}; no machine is written",
                args.machine,
                table::behind(&searched, found, &goal)
            )))
        }
        Some(found) => prove(args, &search, found, &scenes),
    };
    let not_checked = left_open_of_files();
    say_not_checked(&not_checked);
    let (proofs, ended) = match ended {
        Ok(proofs) => (proofs, Ok(())),
        Err(failure) => (vec![], Err(failure)),
    };
    if args.files.are_asked() {
        let report = Report {
            format_version: FORMAT_VERSION,
            command: "explore",
            workload: &workload,
            goal: &goal,
            seed: args.seed,
            columns: COLUMNS.iter().map(|own| own.name).collect(),
            searched: &searched,
            proofs,
            not_checked,
        };
        args.files.write(&report)?;
    }
    ended
}

/// Why no machine is found, and what the file of an earlier search is.
fn nothing_found(file: &std::path::Path, searched: &Searched) -> String {
    let nearest = searched.nearest().filter(|own| own.has_figures());
    let why = match nearest {
        Some(own) => format!(
            "no machine is found: of the nearest that was tried, {}",
            own.missed.join("; ")
        ),
        None => "no machine that was tried has figures; the reasons are above".to_owned(),
    };
    match file.exists() {
        true => format!("{why}; {} is of an earlier search", file.display()),
        false => why,
    }
}

/// The base, what was found, and what a random search found, side by side, each by its schedule.
fn beside_base(search: &Search<'_>, searched: &Searched) {
    let mut machines = vec![];
    for (name, tried) in table::shown(searched) {
        let machine = match std::ptr::eq(tried, &searched.base) {
            true => Ok(search.space.base.clone()),
            false => search.machine(tried),
        };
        // A point that breaks a rule is none to compare.
        if let Ok(machine) = machine {
            machines.push(machine.renamed(name));
        }
    }
    let workload = Workload {
        fidelity: Fidelity::Schedule,
        ..search.workload
    };
    match Comparison::of(&machines, search.scenes, &workload, &()) {
        Ok(found) => compare::table::print(&found),
        Err(error) => say!("no figures: {error}"),
    }
}

/// Writes the machine, and compares its Verilog with the golden models on each scene.
fn prove(
    args: &ExploreArgs,
    search: &Search<'_>,
    found: &Tried,
    scenes: &[Scene],
) -> Result<Vec<Compared>, Failure> {
    let machine = search.machine(found)?;
    let text = format!("{}{}", head(args.seed), machine.to_toml()?);
    let file = Found::new(&args.found);
    file.keep_unproved(&text)?;
    let mut all = vec![];
    for scene in scenes {
        let mut own = scene.clone();
        machine.prepare(&mut own)?;
        let config = machine.hardware_for(&own)?.config;
        let bar = progress::bar(0, "verifying");
        let proof = Proof::of(&config, &own, None, &Shown(&bar));
        bar.finish_and_clear();
        let Proof {
            vectors,
            elements,
            pixels,
        } = proof?;
        prose!(
            0,
            "its Verilog was verified on {}: no mismatch in any bit or cycle of {} of {} feature vectors, \
             {} of {} elements and {} of {} pixels of splat units",
            scene.name(),
            vectors[0],
            vectors[1],
            elements[0],
            elements[1],
            pixels[0],
            pixels[1]
        );
        all.push(Compared {
            scene: scene.name().to_owned(),
            vectors,
            elements,
            pixels,
        });
    }
    file.write(&text)?;
    say!("written to {}", args.found.display());
    Ok(all)
}

/// The command that found a machine, as the head of its file.
fn head(seed: u64) -> String {
    let words: Vec<String> = std::env::args_os()
        .skip(1)
        .map(|own| own.to_string_lossy().replace(char::is_control, " "))
        .collect();
    let command = shell_words::join(&words);
    format!("# Found by potamoi {command}, with seed {seed}.\n")
}

fn usage(error: SpaceError) -> Failure {
    match error {
        SpaceError::Machine(error) => error.into(),
        other => Failure::Usage(format!("--vary: {other}")),
    }
}

impl ExploreArgs {
    fn goal(&self) -> Result<Goal, Failure> {
        for (name, limit) in [
            ("--max-area", self.max_area),
            ("--min-psnr", self.min_psnr),
            ("--min-fps", self.min_fps),
            ("--max-mj", self.max_mj),
        ] {
            if let Some(value) = limit.filter(|value| !(value.is_finite() && *value > 0.0)) {
                return Err(Failure::Usage(format!(
                    "{name} {value}: expected a positive number"
                )));
            }
        }
        Ok(Goal {
            objective: self.objective.into(),
            max_area: self.max_area,
            min_psnr: self.min_psnr,
            min_fps: self.min_fps,
            max_mj: self.max_mj,
            needs_reached_clock: (self.vary.iter())
                .any(|own| own.fields.iter().any(|field| field == CLOCK[1])),
            // The search knows once the base has figures.
            needs_known_clock: false,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn assumed_fields_are_fields_of_the_system() {
        let paper = Machine::named("paper").unwrap();
        for field in ASSUMED {
            assert!(paper.value(field).is_some(), "{field}");
        }
    }
}
