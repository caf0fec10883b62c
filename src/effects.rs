//! `potamoi effects`: what a scene and a camera path call for.

mod compare;
mod measure;
mod picture;
mod report;

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use potamoi_analysis::{Analysis, Hardware, Surroundings};
use potamoi_base::camera::Camera;
use potamoi_base::effects::Effect;
use potamoi_explore::Chosen;
use potamoi_reference::Twins;
use potamoi_reference::observer::Observed;
use potamoi_scene::Scene;
use potamoi_system::effects::{EffectCycles, EffectMeter};

use crate::args::Common;
use crate::failure::Failure;
use crate::files;
use crate::progress;
use crate::scene::SceneArgs;

use compare::{Forced, Without};
use measure::Stopwatch;
use report::{FORMAT_VERSION, Found, Report, UnitReport};

#[derive(Debug, Args)]
pub(crate) struct EffectsArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Frames of the camera path
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Frames a second of the scene's own camera path
    #[arg(long, value_name = "FPS", default_value_t = 30.0)]
    fps: f64,
    /// Keep the camera where it is on every frame
    #[arg(long, conflicts_with = "fps")]
    still: bool,
    /// Where full frames are rendered
    #[arg(long, value_enum, default_value_t = Where::Local)]
    scenario: Where,
    /// Pairs of timed runs, one with and one without an effect; medians are reported; 0: no timing
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(0..100))]
    pairs: u32,
    /// Run the frame on the Verilated units too: the whole configuration, and the part that the
    /// scene calls for
    #[arg(long)]
    rtl: bool,
    /// Plot of the result as SVG
    #[arg(long, value_name = "FILE", value_parser = crate::charts::svg)]
    plot: Option<PathBuf>,
    /// Write the report as JSON; of several scenes or frames, one report of all
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Where {
    /// By the device itself
    Local,
    /// Elsewhere, over a wireless link
    Remote,
}

pub(crate) fn run(common: &Common, args: &EffectsArgs) -> Result<(), Failure> {
    files::prepare([args.plot.as_ref(), args.json.as_ref()])?;
    let begun = Instant::now();
    if args.plot.is_some() && args.pairs == 0 {
        return Err(Failure::Usage(
            "--plot draws wall times: expected --pairs 1 or more".to_owned(),
        ));
    }
    let choices = args.scene.choices()?;
    let mut scene = args.scene.open_as_called_for(args.scene.name())?;
    let Chosen { config, preset } = common.chosen_for(&scene)?;
    let path = args.path(&scene)?;
    if let Some(first) = path.first() {
        scene.set_camera(*first);
    }
    let around = Surroundings {
        is_remote: args.scenario == Where::Remote,
    };
    let spinner = progress::spinner("looking at the scene");
    let analysis = Analysis::of(&scene, &path, &config, around)?;
    let hardware = Hardware::of(&scene, &config)?;
    spinner.set_message("counting cycles");
    let (cycles, counts) = {
        let mut twins = Twins::new(&config);
        let mut meter = EffectMeter::new(&config);
        let mut units = Observed::new(&mut twins, &config).by(&mut meter);
        let rendered = scene.render_fixed(&config, &mut units)?;
        (meter.cycles(), rendered.counts)
    };
    let watch = Stopwatch {
        scene: &scene,
        config: &config,
        path: &path,
        pairs: args.pairs,
    };
    let left = match analysis.calls_for(Effect::Disocclusion) {
        true => watch.pixels_left()?,
        false => 0,
    };
    let mut effects = vec![];
    for finding in &analysis.findings {
        spinner.set_message(format!("measuring {}", finding.effect));
        let wall = watch.wall(finding.effect, finding.is_called_for)?;
        let work = cost(finding.effect, &cycles, &counts, left, &scene);
        let is_there = watch.is_there(finding.effect);
        effects.push(Found::new(finding, work, wall, is_there, &scene));
    }
    let forced = match Effect::ALL.iter().any(|effect| choices.forces(*effect)) {
        true => {
            spinner.set_message("forcing effects");
            Some(Forced::find(&watch, &hardware, choices, around.is_remote)?)
        }
        false => None,
    };
    let mut without = vec![];
    for finding in &analysis.findings {
        if choices.leaves_out(finding.effect) {
            spinner.set_message(format!("leaving out {}", finding.effect));
            without.push(Without::find(&watch, finding)?);
        }
    }
    let rtl = match args.rtl {
        true => {
            spinner.set_message("building and running the Verilated units");
            Some(watch.rtl(&hardware)?)
        }
        false => None,
    };
    spinner.finish_and_clear();
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "effects",
        scene: scene.name().to_owned(),
        algorithm: scene.model().algorithm(),
        width: scene.camera().width,
        height: scene.camera().height,
        frames: path.len(),
        configuration: config.hash(),
        preset,
        pairs: args.pairs,
        effects,
        units: UnitReport::new(&hardware, &analysis),
        forced,
        without,
        rtl,
        seconds: begun.elapsed().as_secs_f64(),
    };
    report.print();
    if let Some(file) = &args.plot {
        picture::plot(file, &report)?;
    }
    if let Some(file) = &args.json {
        files::write_json(file, &report)?;
    }
    let differs = |what: &str| Err(Failure::Check(format!("{what} changed a result")));
    match (&report.forced, &report.rtl) {
        (Some(forced), _) if !forced.is_same() => {
            differs("forcing effects that are not called for")
        }
        (_, Some(rtl)) if !rtl.is_same => {
            differs("leaving out of the Verilated units what is not called for")
        }
        _ => Ok(()),
    }
}

impl EffectsArgs {
    fn path(&self, scene: &Scene) -> Result<Vec<Camera>, Failure> {
        if self.still {
            return Ok(vec![*scene.camera(); self.frames as usize]);
        }
        Ok(scene.path(self.fps, self.frames)?)
    }
}

/// What an effect costs when it is simulated: where, and how many of what.
fn cost(
    effect: Effect,
    cycles: &EffectCycles,
    counts: &potamoi_scene::FrameCounts,
    left: u64,
    scene: &Scene,
) -> report::Work {
    use report::Work;
    let splats = counts.splats.unwrap_or_default();
    let terms = |degree: u8| 2 * u64::from(degree) + 1;
    match effect {
        // Of the runs that interpolate, which without it would read one vertex in as many cycles.
        Effect::Trilinear => Work::cycles("gathering unit", cycles.interpolating),
        Effect::Exponential => Work::cycles("vector unit", cycles.exponentials),
        Effect::SphericalHarmonics(degree) => {
            let is_splats = scene.model().is_splats();
            match (scene.facts().perceptron.is_some(), is_splats) {
                (true, true) => {
                    let codes = splats.visible * terms(degree);
                    Work::amount("GPU", codes, "codes of visible Gaussians' directions")
                }
                (true, false) => {
                    let codes = counts.rays * terms(degree);
                    Work::amount("GPU", codes, "codes of rays' directions")
                }
                (false, true) => {
                    let products = 3 * splats.visible * terms(degree);
                    Work::amount("GPU", products, "multiplications of visible Gaussians")
                }
                // Colours stored as linear in the direction.
                (false, false) => Work::cycles("MAC array", cycles.array),
            }
        }
        Effect::ViewMlp => Work::cycles("MAC array", cycles.array),
        Effect::HashLevels => Work::amount("DRAM", counts.scattered_bytes, "bytes row by row"),
        Effect::Segments => Work::cycles("gathering unit", cycles.further_passes),
        Effect::Sorting => Work::amount("GPU", splats.visible, "visible Gaussians"),
        Effect::EarlyTermination => Work::amount("compositing", counts.rays, "rays"),
        Effect::Warping => Work::amount("GPU", counts.rays, "pixels a frame"),
        Effect::Disocclusion => {
            Work::amount("all units", left, "pixels of the path's warped frames")
        }
        Effect::VoidTest => Work::amount("GPU", counts.samples, "samples"),
        Effect::OctreeMerging => Work::amount("GPU", splats.gaussians, "Gaussians"),
        Effect::RemoteLink => Work::amount("link", counts.rays, "pixels a full frame"),
        Effect::RandomDram => Work::amount("DRAM", counts.scattered_bytes, "bytes"),
    }
}
