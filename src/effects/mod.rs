//! `potamoi effects`: the effects that a scene and a camera path call for.

mod picture;
mod report;

use std::path::PathBuf;
use std::time::Instant;

use clap::{Args, ValueEnum};
use potamoi_analysis::Surroundings;
use potamoi_base::camera::Camera;
use potamoi_explore::effects::EffectsStudy;
use potamoi_scene::Scene;

use crate::args::Common;
use crate::charts;
use crate::failure::Failure;
use crate::progress::{self, Shown};
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;
use crate::scene::{SceneArgs, say_not_checked};

use report::{FORMAT_VERSION, Report};

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "effects",
    version: FORMAT_VERSION,
    shape: shape::<Report>,
};

#[derive(Debug, Args)]
pub(crate) struct EffectsArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Number of frames on the camera path
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..))]
    frames: u32,
    /// Frame rate of the scene's own camera path, or of a recorded motion
    #[arg(long, value_name = "FPS", default_value_t = 30.0)]
    fps: f64,
    /// Keep the camera at its pose in every frame
    #[arg(long, conflicts_with = "fps")]
    still: bool,
    /// Where full frames are rendered
    #[arg(long, value_enum, default_value_t = Where::Local)]
    scenario: Where,
    /// Number of pairs of timed runs, with and without an effect, whose median is reported; 0: no
    /// timing
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..100))]
    pairs: u32,
    /// Also run the frame on the Verilated units: with the whole configuration, and with the parts
    /// that the scene calls for
    #[arg(long)]
    run_rtl: bool,
    /// Write a plot of the result as SVG
    #[arg(long, value_name = "FILE", value_parser = crate::charts::svg)]
    plot: Option<PathBuf>,
    #[command(flatten)]
    files: ReportFiles,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum Where {
    /// On the device
    Local,
    /// On a server, over a wireless link
    Remote,
}

pub(crate) fn run(common: &Common, args: &EffectsArgs) -> Result<(), Failure> {
    args.files.prepare([args.plot.as_ref()])?;
    let begun = Instant::now();
    if args.plot.is_some() && args.pairs == 0 {
        return Err(Failure::Usage(
            "--plot draws wall times: expected --pairs 1 or more".to_owned(),
        ));
    }
    let choices = args.scene.choices()?;
    let mut scene = args.scene.open_as_called_for(args.scene.name(), common)?;
    let chosen = common.chosen_for(&scene)?;
    let path = args.path(&scene)?;
    if let Some(first) = path.first() {
        scene.set_camera(*first);
    }
    let study = EffectsStudy {
        scene: &scene,
        chosen: &chosen,
        path: &path,
        around: Surroundings {
            is_remote: args.scenario == Where::Remote,
        },
        choices,
        pairs: args.pairs,
        rtl: args.run_rtl,
    };
    let spinner = progress::spinner("looking at the scene");
    let found = study.run(&Shown(&spinner))?;
    spinner.finish_and_clear();
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "effects",
        found,
        seconds: begun.elapsed().as_secs_f64(),
        not_checked: scene.left_open(),
    };
    let found = &report.found;
    report::print(found);
    say_not_checked(&report.not_checked);
    if let Some(file) = &args.plot {
        charts::write(file, &picture::spec(found))?;
    }
    args.files.write(&report)?;
    let differs = |what: &str| Err(Failure::check(format!("{what} changed a result")));
    match (&found.forced, &found.rtl) {
        (Some(forced), _) if !forced.is_same() => {
            differs("forcing effects that are not called for")
        }
        (_, Some(rtl)) if !rtl.is_same => {
            differs("leaving out parts of the Verilated units that are not called for")
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
