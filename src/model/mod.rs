//! `potamoi model`: time, energy and quality of a scene's frames on the whole system.

mod areas;
mod assumptions;

pub(crate) mod clock;
pub(crate) mod ladder;
mod limits;
mod means;
mod octree;
pub(crate) mod pictures;
mod report;
mod rivals;
mod sensitivity;
mod side_by_side;
mod tables;

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use potamoi_base::outputs as files;
use potamoi_explore::Setup;
use potamoi_explore::system::{Accelerators, Fidelity, Merging, Modelled, Sensitivity};
use potamoi_machines::machine::Section;
use potamoi_machines::{Machine, WINDOW};
use potamoi_scene::{Scene, scenes_named};
use potamoi_system::system_model::work::{PathOptions, PathParts, PathWork};
use potamoi_system::system_model::{Scenario, System, Variant, chrome_trace};

use crate::args::{ClockArgs, Common};
use crate::charts;
use crate::failure::Failure;
use crate::progress::{self, Shown};
use crate::published::{Published, Shape, shape};
use crate::report_files::ReportFiles;
use crate::scene::{SceneArgs, say_not_checked};
use crate::suggest;
use crate::warp::RulesOf;
use report::Report;

/// The reports of `--json`.
pub(crate) const REPORTS: [Published; 5] = [
    published("model", shape::<Report<Modelled>>),
    published("model --ladder", shape::<Report<Fidelity>>),
    published("model --octree", shape::<Report<Merging>>),
    published("model --rivals", shape::<Report<Accelerators>>),
    published("model --sensitivity", shape::<Report<Sensitivity>>),
];

const fn published(command: &'static str, shape: Shape) -> Published {
    Published {
        command,
        version: report::FORMAT_VERSION,
        shape,
    }
}

#[derive(Debug, Args)]
pub(crate) struct ModelArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Scenes to compare, separated by commas; `all` is every built-in scene in every
    /// representation, `cairn:all` one scene in every representation, `all:ngp` every scene in one
    /// [default: the one of --scene]
    #[arg(
        long,
        value_name = "SCENE,...",
        value_delimiter = ',',
        conflicts_with_all = ["scene", "chrome_trace"]
    )]
    scenes: Vec<String>,
    /// Variants of the system: baseline, fs, fs+gu, sparw, sparw+fs, potamoi, ds2, temp; speed-ups
    /// are relative to the baseline [default: the machine's, or all]
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    variants: Vec<String>,
    /// Where full frames are rendered
    #[arg(long, value_enum, default_value_t = Scenarios::Local)]
    scenario: Scenarios,
    /// Number of target frames warped from one reference [default: the machine's, or 16]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    window: Option<u32>,
    /// Maximum angle at a point between the rays of reference and target; pixels beyond it are
    /// rendered [default: the machine's, or no limit]
    #[arg(long, value_name = "DEG")]
    phi: Option<f64>,
    /// Rules of warping: which pixels of a target are warped and which are rendered [default: the
    /// machine's, or potamoi]
    #[arg(long, value_enum)]
    profile: Option<RulesOf>,
    /// Number of frames on the camera path
    #[arg(long, value_name = "N", default_value_t = 30, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Frame rate of the scene's own camera path, or of a recorded motion
    #[arg(long, value_name = "FPS", default_value_t = 30.0)]
    fps: f64,
    /// Description of the system as TOML, in which omitted fields have the paper's values; or the
    /// paper's system with another GPU, by name: xavier, xavier-15w, orin-nx, agx-orin and others
    /// [default: the machine's, or the paper's system]
    #[arg(long, value_name = "SYSTEM")]
    system: Option<PathBuf>,
    /// Area, clock and energy of units, as written by `potamoi synth --json`
    /// [default: the built-in results and formulas]
    #[arg(long, value_name = "FILE")]
    synth: Option<PathBuf>,
    #[command(flatten)]
    clock: ClockArgs,
    /// Write a plot of a frame's energy by part and variant, as SVG
    #[arg(
        long,
        value_name = "FILE",
        value_parser = crate::charts::svg,
        conflicts_with_all = ["scenes", "ladder", "octree", "rivals", "sensitivity"]
    )]
    plot_energy: Option<PathBuf>,
    /// Write a roofline plot as SVG: multiplications per second of each variant, and the limits of
    /// array and memory
    #[arg(
        long,
        value_name = "FILE",
        value_parser = crate::charts::svg,
        conflicts_with_all = ["scenes", "ladder", "octree", "rivals", "sensitivity"]
    )]
    plot_roofline: Option<PathBuf>,
    /// Refused: the GPU has no calibrated shares any more
    #[arg(long, hide = true)]
    calibrate: bool,
    /// Compare cycles and time of a frame by formulas, by cycle models and by the Verilated units,
    /// each with its error and wall time
    #[arg(long, conflicts_with_all = ["scenes", "chrome_trace", "scenario", "variants", "window", "phi", "profile", "frames", "fps"])]
    ladder: bool,
    /// Compare merged and unmerged cells of splats: the saving by fuller MVoxels
    #[arg(long, conflicts_with_all = ["chrome_trace", "ladder", "scenario", "variants", "window", "phi", "profile", "frames", "fps"])]
    octree: bool,
    /// Number of times that cell sides are halved before merging, beyond the coarsest cells that
    /// fit an MVoxel
    #[arg(long, value_name = "N", default_value_t = 0, requires = "octree", value_parser = clap::value_parser!(u32).range(..=8))]
    halvings: u32,
    /// Compare with published accelerators, such as NeuRex and NGPC
    #[arg(long, conflicts_with_all = ["chrome_trace", "ladder", "octree", "scenario", "variants"])]
    rivals: bool,
    /// Vary the figures of the GPUs, up to a GPU that takes no time and no energy, and tell which
    /// conclusions hold within the model's own error
    #[arg(long, conflicts_with_all = ["chrome_trace", "ladder", "octree", "rivals"])]
    sensitivity: bool,
    #[command(flatten)]
    files: ReportFiles,
    /// Write the schedule as a Chrome trace, for Perfetto; with several variants, that of the last
    #[arg(long, value_name = "FILE")]
    chrome_trace: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Scenarios {
    /// On the device
    Local,
    /// On a server, over a wireless link
    Remote,
    /// Both, one after the other
    Both,
}

impl Scenarios {
    const fn all(self) -> &'static [Scenario] {
        match self {
            Self::Local => &[Scenario::Local],
            Self::Remote => &[Scenario::Remote],
            Self::Both => &[Scenario::Local, Scenario::Remote],
        }
    }
}

pub(crate) fn run(common: &Common, args: &ModelArgs) -> Result<(), Failure> {
    if args.calibrate {
        let message = "--calibrate: the GPU has no calibrated shares any more: its kernels are \
                       counted, and its rates are those of a device file; leave it out";
        return Err(Failure::Usage(message.to_owned()));
    }
    let written = [&args.chrome_trace, &args.plot_energy, &args.plot_roofline];
    args.files.prepare(written.map(Option::as_ref))?;
    let machine = common.machine()?;
    let variants = args.variants(&machine)?;
    let system = args.system(&machine)?;
    if args.ladder {
        return ladder::run(common, args, &system);
    }
    let names = match args.scenes.is_empty() {
        true => vec![args.scene.name().to_owned()],
        false => scenes_named(&args.scenes),
    };
    if args.octree {
        return octree::run(common, args, &system, &names);
    }
    if args.rivals {
        return rivals::run(common, args, &system, &names);
    }
    if args.sensitivity {
        return sensitivity::run(common, args, &system, &names);
    }
    let mut report = Report::new("model", &system, vec![]);
    for name in &names {
        let mut setup = args.setup(common, &system, args.scene.open_named(name, common)?)?;
        let (path, was_kept) = args.count(&mut setup, &machine)?;
        let cameras = setup.scene.path(args.fps, args.frames)?;
        let scenarios = args.scenario.all();
        let counted = (&path, was_kept);
        let (found, last) = Modelled::of(counted, &setup, &variants, scenarios, &cameras)?;
        if names.len() == 1 {
            tables::print(&found, &system);
            say_not_checked(&found.not_checked);
        }
        if let Some(file) = &args.plot_energy {
            charts::write(file, &pictures::energy(&found))?;
        }
        if let Some(file) = &args.plot_roofline {
            charts::write(file, &pictures::roofline(&found, &system))?;
        }
        if let (Some(file), Some(timeline)) = (&args.chrome_trace, &last) {
            files::write_json(file, &chrome_trace(timeline))?;
        }
        report.scenes.push(found);
        args.files.write(&report)?;
    }
    if names.len() > 1 {
        side_by_side::print(&report);
        let outcomes = report.scenes.iter().flat_map(|found| &found.outcomes);
        assumptions::of_system(&system, outcomes.map(|o| o.scenario));
    }
    Ok(())
}

impl ModelArgs {
    fn system(&self, machine: &Machine) -> Result<System, Failure> {
        let has_own = machine.sections().contains(&Section::System);
        match &self.system {
            Some(given) if has_own => Err(Failure::Usage(format!(
                "--system {}: {} has a [system]: leave one of both out",
                given.display(),
                machine.name
            ))),
            Some(given) => Ok(System::named(given)?),
            None => Ok(machine.system.clone()),
        }
    }

    /// The baseline and the requested variants.
    fn variants(&self, machine: &Machine) -> Result<Vec<Variant>, Failure> {
        let [baseline, ..] = Variant::ALL;
        if self.variants.is_empty() {
            let own = machine.path.variant();
            return Ok(match machine.sections().contains(&Section::Path) {
                false => Variant::ALL.to_vec(),
                true if own == baseline => vec![baseline],
                true => vec![baseline, own],
            });
        }
        let mut all = vec![baseline];
        for name in &self.variants {
            let Some(variant) = Variant::named(name) else {
                let known = Variant::ALL.map(|v| v.name).join(", ");
                return Err(Failure::Usage(suggest::with_nearest(
                    format!("--variants {name}: expected some of {known}"),
                    name,
                    Variant::ALL.map(|v| v.name),
                )));
            };
            if !all.contains(&variant) {
                all.push(variant);
            }
        }
        Ok(all)
    }

    fn setup(&self, common: &Common, system: &System, scene: Scene) -> Result<Setup, Failure> {
        Ok(Setup::new(
            self.clock.chosen(common.chosen_for(&scene)?)?,
            system,
            scene,
            self.synth.as_deref(),
        )?)
    }

    /// The work of the scene's path and the replay of its memory accesses, counted or cached.
    fn count(&self, setup: &mut Setup, machine: &Machine) -> Result<(PathWork, bool), Failure> {
        let (system, path) = (&setup.system, &machine.path);
        let options = PathOptions {
            frames: self.frames,
            fps: self.fps,
            window: self.window.or(path.window).unwrap_or(WINDOW),
            phi: self.phi.or(path.phi),
            profile: (self.profile.map(Into::into))
                .or(path.profile)
                .unwrap_or_default(),
            array: [system.array_rows.into(), system.array_columns.into()],
            is_double_buffered: system.array_double_buffered,
            cache: system.gpu.cache_bytes(),
            parts: PathParts::All,
        };
        let bar = progress::bar(PathWork::steps(&options), "rendering and counting");
        let found = setup.count(&options, &Shown(&bar))?;
        bar.finish_and_clear();
        Ok(found)
    }
}
