//! `potamoi warp`: sparse radiance warping along a camera path.

mod methods;
mod picture;
mod rates;
mod report;
mod source;
mod tables;
mod timing;

use std::path::PathBuf;

use clap::Args;
use indicatif::ProgressBar;
use potamoi_base::camera::Camera;
use potamoi_base::effects::Effect;
use potamoi_base::outputs as files;
use potamoi_explore::warping::{
    Method, MethodSettings, PlannedMethod, Source, Study, Truth, Warping,
};
use potamoi_scene::scenes_named;
use potamoi_system::path_schedule::chrome_trace;
use potamoi_warp::{Frame, Rule};

use crate::failure::Failure;
use crate::progress::{self, Shown};
use crate::published::{Published, one_of_three};
use crate::report_files::ReportFiles;
use crate::scene::SceneArgs;

use methods::MethodArgs;
pub(crate) use methods::RulesOf;
use report::{FORMAT_VERSION, Report, Reports};
use source::DepthArgs;
use timing::TimingArgs;

#[derive(Debug, Args)]
pub(crate) struct WarpArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Scenes to compare, separated by commas; `all` is every built-in scene in every
    /// representation, `cairn:all` one scene in every representation, `all:ngp` every scene in one
    /// [default: the one of --scene]
    #[arg(
        long,
        value_name = "SCENE,...",
        value_delimiter = ',',
        conflicts_with_all = ["scene", "out_dir", "frame_ms", "live"]
    )]
    scenes: Vec<String>,
    #[command(flatten)]
    methods: MethodArgs,
    /// Number of frames on the camera path [default: three windows, or all frames of a file]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Frame rate of the scene's own camera path, or of a recorded motion
    #[arg(
        long,
        value_name = "FPS,...",
        value_delimiter = ',',
        default_value = "30"
    )]
    fps: Vec<f64>,
    #[command(flatten)]
    depth: DepthArgs,
    #[command(flatten)]
    timing: TimingArgs,
    /// References that the remote renderer loses, by number from 0 [default: none]
    #[arg(long, value_name = "N,...", value_delimiter = ',')]
    lose: Vec<usize>,
    /// Folder for the files; it is created if missing, files written earlier by the command are
    /// replaced, and other files stay
    #[arg(long, value_name = "DIR")]
    out_dir: Option<PathBuf>,
    #[command(flatten)]
    files: ReportFiles,
}

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "warp",
    version: FORMAT_VERSION,
    shape: one_of_three::<Report, Reports, rates::Report>,
};

pub(crate) fn run(args: &WarpArgs) -> Result<(), Failure> {
    args.files.prepare([args.timing.chrome_trace.as_ref()])?;
    args.timing.check()?;
    args.methods.check()?;
    let bar = progress::bar(0, "warping");
    if args.fps.len() > 1 {
        return args.at_rates(&bar);
    }
    let mut truth = Truth::default();
    if args.scenes.is_empty() {
        let found = args.found(args.scene.name(), &mut truth, &bar)?;
        bar.finish_and_clear();
        tables::print(&found, args.timing.chrome_trace.as_ref());
        if let Some(folder) = &args.out_dir {
            crate::stdout::say!("  frames and origins of their pixels: {}", folder.display());
        }
        let report = Report {
            format_version: FORMAT_VERSION,
            command: "warp",
            found,
        };
        return args.files.write(&report);
    }
    let names = scenes_named(&args.scenes);
    let mut reports = Reports {
        format_version: FORMAT_VERSION,
        command: "warp",
        scenes: vec![],
    };
    for (at, name) in names.iter().enumerate() {
        bar.set_message(format!("{name}, {} of {}", at + 1, names.len()));
        reports.scenes.push(args.found(name, &mut truth, &bar)?);
        args.files.write(&reports)?;
    }
    bar.finish_and_clear();
    reports.print();
    Ok(())
}

impl WarpArgs {
    /// Warps one scene by all methods.
    fn found(&self, name: &str, truth: &mut Truth, bar: &ProgressBar) -> Result<Warping, Failure> {
        let source = source::open(&self.scene, name)?;
        let fps = self.fps[0];
        let path = source.path(fps, self.frames, 3 * self.methods.longest_window())?;
        self.along(&source, &path, fps, truth, bar)
    }

    /// The methods, with their rules and plans.
    fn planned(&self, source: &Source) -> Result<Vec<PlannedMethod>, Failure> {
        let depths = self.depth.choices(source);
        let names: Vec<String> = depths.iter().map(ToString::to_string).collect();
        let methods = self.methods.settings(&names);
        self.check(&methods)?;
        let warps_still = self.scene.choices()?.forces(Effect::Warping);
        let mut planned = vec![];
        for settings in methods {
            let rule = self.methods.rule(&settings);
            rule.check()?;
            planned.push(PlannedMethod {
                rule: Rule {
                    warps_still,
                    ..rule
                },
                plan: self.methods.plan(&settings, source),
                settings,
            });
        }
        Ok(planned)
    }

    /// Warps the frames of a path by all methods.
    fn along(
        &self,
        source: &Source,
        path: &[Camera],
        fps: f64,
        truth: &mut Truth,
        bar: &ProgressBar,
    ) -> Result<Warping, Failure> {
        let planned = self.planned(source)?;
        if let Some(folder) = &self.out_dir {
            files::prepare([Some(&folder.join("frame.0000.png"))])?;
        }
        let mut show = |frame: &Frame| match &self.out_dir {
            Some(folder) => picture::write(folder, frame),
            None => Ok(()),
        };
        let study = Study {
            source,
            path,
            depths: &self.depth.choices(source),
            fps: source.rate(fps),
            timetable: self.timing.timetable(),
            lost: &self.lose,
        };
        let found = study.run(&planned, truth, &Shown(bar), &mut show)?;
        let schedule = found.variants.last().and_then(|v| v.schedule.as_ref());
        if let (Some(file), Some(schedule)) = (&self.timing.chrome_trace, schedule) {
            files::write_json(file, &chrome_trace(schedule))?;
        }
        Ok(found)
    }

    /// Refuses options that apply to a single method only.
    fn check(&self, methods: &[MethodSettings]) -> Result<(), Failure> {
        if self.out_dir.is_some() && methods.len() != 1 {
            return Err(Failure::Usage(
                "--out-dir: expected one method, whose frames are written: name one --method, \
                 --window, --phi and --depth"
                    .to_owned(),
            ));
        }
        if !self.lose.is_empty() {
            if methods
                .iter()
                .any(|settings| settings.method != Method::SpaRw)
            {
                return Err(Failure::Usage(
                    "--lose: only the references of --method sparw can be lost".to_owned(),
                ));
            }
            if self.timing.is_scheduled() && !self.timing.has_server() {
                return Err(Failure::Usage(
                    "--lose: expected a server, whose references are lost: give --server-ms"
                        .to_owned(),
                ));
            }
        }
        if self.timing.is_asked() && (methods.len() != 1 || methods[0].method != Method::SpaRw) {
            return Err(Failure::Usage(
                "--frame-ms, --live: expected one method: --method sparw, and one --window, \
                 --phi and --depth"
                    .to_owned(),
            ));
        }
        Ok(())
    }
}
