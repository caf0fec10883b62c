//! `potamoi warp`: sparse radiance warping along a camera path.

mod measure;
mod picture;
mod report;
mod source;
mod tables;
mod timing;
mod ways;

use std::path::PathBuf;
use std::time::Instant;

use clap::Args;
use indicatif::ProgressBar;
use potamoi_base::camera::Camera;
use potamoi_base::effects::Effect;
use potamoi_base::record::Notes;
use potamoi_system::runtime::Schedule;
use potamoi_warp::{Counts, Frame, Plan, Rule, Warper};

use crate::failure::Failure;
use crate::files;
use crate::progress;
use crate::scene::{SceneArgs, named};

use measure::{Footage, Measured, Truth};
use report::{FORMAT_VERSION, Found, Report, Reports, Variant};
use source::{DepthArgs, Source};
use timing::TimingArgs;
pub(crate) use ways::RulesOf;
use ways::{Method, Way, WayArgs, frames};

#[derive(Debug, Args)]
pub(crate) struct WarpArgs {
    #[command(flatten)]
    scene: SceneArgs,
    /// Scenes side by side, with commas between them; `all` is every built-in scene in every
    /// representation, `cairn:all` every one of a scene, `all:ngp` every scene in one [default: the
    /// one of --scene]
    #[arg(
        long,
        value_name = "SCENE,...",
        value_delimiter = ',',
        conflicts_with_all = ["scene", "out_dir", "frame_ms", "live"]
    )]
    scenes: Vec<String>,
    #[command(flatten)]
    ways: WayArgs,
    /// Frames of the camera path [default: three windows, or all that a file has]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Frames a second of the scene's own camera path
    #[arg(long, value_name = "FPS", default_value_t = 30.0)]
    fps: f64,
    #[command(flatten)]
    depth: DepthArgs,
    #[command(flatten)]
    timing: TimingArgs,
    /// References that never arrive, by number from 0, as if a remote renderer lost them [default:
    /// none]
    #[arg(long, value_name = "N,...", value_delimiter = ',')]
    lose: Vec<usize>,
    /// Folder for the files: it is made where there is none, files that the command wrote earlier
    /// are replaced, and others stay
    #[arg(long, value_name = "DIR")]
    out_dir: Option<PathBuf>,
    /// Write the report as JSON; of several scenes or frames, one report of all
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// What all ways of a scene share.
struct Stage<'a> {
    path: &'a [Camera],
    footage: &'a Footage,
    fps: Option<f64>,
    bar: &'a ProgressBar,
}

pub(crate) fn run(args: &WarpArgs) -> Result<(), Failure> {
    files::prepare([args.json.as_ref(), args.timing.chrome_trace.as_ref()])?;
    args.timing.check()?;
    let bar = progress::bar(0, "warping");
    let mut truth = Truth::default();
    if args.scenes.is_empty() {
        let found = args.found(args.scene.name(), &mut truth, &bar)?;
        bar.finish_and_clear();
        found.print(args.timing.chrome_trace.as_ref());
        if let Some(folder) = &args.out_dir {
            crate::stdout::say!("  frames and origins of their pixels: {}", folder.display());
        }
        let report = Report {
            format_version: FORMAT_VERSION,
            command: "warp",
            found,
        };
        return match &args.json {
            Some(path) => Ok(files::write_json(path, &report)?),
            None => Ok(()),
        };
    }
    let names = named(&args.scenes);
    let mut reports = Reports {
        format_version: FORMAT_VERSION,
        command: "warp",
        scenes: vec![],
    };
    for (at, name) in names.iter().enumerate() {
        bar.set_message(format!("{name}, {} of {}", at + 1, names.len()));
        reports.scenes.push(args.found(name, &mut truth, &bar)?);
        if let Some(path) = &args.json {
            files::write_json(path, &reports)?;
        }
    }
    bar.finish_and_clear();
    reports.print();
    Ok(())
}

impl WarpArgs {
    /// Warps one scene in every way.
    fn found(&self, name: &str, truth: &mut Truth, bar: &ProgressBar) -> Result<Found, Failure> {
        let start = Instant::now();
        let source = Source::open(&self.scene, name)?;
        let path = source.path(self.fps, self.frames, 3 * self.ways.longest_window())?;
        let depths = self.depth.choices(&source);
        let names: Vec<String> = depths.iter().map(ToString::to_string).collect();
        let ways = self.ways.ways(&names);
        self.check(&ways)?;
        for way in &ways {
            self.ways.rule(way).check()?;
        }
        if let Some(folder) = &self.out_dir {
            files::prepare([Some(&folder.join("frame.0000.png"))])?;
        }
        let mut geometries = vec![];
        let mut notes = Notes::default();
        for depth in &depths {
            geometries.push(source.geometry(depth, &mut notes)?);
        }
        bar.inc_length((path.len() * (ways.len() + 1)) as u64);
        let footage = Footage::new(&source, &path, truth, bar)?;
        let stage = Stage {
            path: &path,
            footage: &footage,
            fps: source.is_timed().then_some(self.fps),
            bar,
        };
        let mut variants = vec![];
        for way in &ways {
            let geometry = &geometries[way.depth];
            let warper = Warper {
                renderer: source.renderer(),
                geometry: geometry.as_deref(),
                rule: Rule {
                    warps_still: self.scene.choices()?.forces(Effect::Warping),
                    ..self.ways.rule(way)
                },
            };
            let plan = Plan::new(&path, &self.ways.plan(way, &source))?;
            let begun = Instant::now();
            let shown = self.show(way, warper, &plan, &stage)?;
            let seconds = begun.elapsed().as_secs_f64();
            let (measured, schedule) = shown;
            let timed = schedule.map(|s| self.timing.done(&s)).transpose()?;
            let depth = names[way.depth].clone();
            variants.push(Variant::new(
                way, depth, measured, &plan, &path, seconds, timed,
            ));
        }
        let mut not_checked = source.left_open(&path);
        not_checked.extend(notes.sentences());
        Ok(Found {
            scene: source.name().to_owned(),
            width: footage.size()[0],
            height: footage.size()[1],
            frames: path.len(),
            fps: source.is_timed().then_some(self.fps),
            model: footage.quality(),
            variants,
            not_checked,
            seconds: start.elapsed().as_secs_f64(),
        })
    }

    /// The frames of one way, and their schedule. References that the schedule
    /// gives up are lost to the frames too, which are then made again.
    fn show<'a>(
        &self,
        way: &Way,
        warper: Warper<'_>,
        plan: &Plan,
        stage: &Stage<'a>,
    ) -> Result<(Measured<'a>, Option<Schedule>), Failure> {
        let Stage {
            path,
            footage,
            fps,
            bar,
        } = *stage;
        let timing = &self.timing;
        let mut lost = self.lose.clone();
        if let Some(none) = lost.iter().find(|n| **n >= plan.references.len()) {
            return Err(Failure::Usage(format!(
                "--lose {none}: there are {} references, from 0",
                plan.references.len()
            )));
        }
        loop {
            let mut measured = Measured::new(footage);
            let mut counts = vec![];
            let mut take = |frame: &Frame| -> Result<(), Failure> {
                measured.add(frame);
                counts.push(Counts::of(&frame.target.classes, |_| true));
                if let Some(folder) = &self.out_dir {
                    picture::write(folder, frame)?;
                }
                bar.inc(1);
                Ok(())
            };
            if timing.is_live() {
                let mut failed = None;
                let schedule = timing.measure(warper, path, plan, &lost, |frame| {
                    if failed.is_none() {
                        failed = take(&frame).err();
                    }
                })?;
                return failed.map_or(Ok((measured, Some(schedule))), Err);
            }
            for frame in frames(way, warper, path, plan, &lost) {
                take(&frame?)?;
            }
            if !timing.is_scheduled() {
                return Ok((measured, None));
            }
            let schedule = timing.schedule(plan, &counts, &path[0], fps, &lost)?;
            let late = TimingArgs::given_up(&schedule);
            let before = lost.len();
            lost.extend(late.into_iter().filter(|n| !self.lose.contains(n)));
            lost.sort_unstable();
            lost.dedup();
            if lost.len() == before {
                return Ok((measured, Some(schedule)));
            }
            bar.inc_length(path.len() as u64);
        }
    }

    /// Refuses what is of one way alone.
    fn check(&self, ways: &[Way]) -> Result<(), Failure> {
        if self.out_dir.is_some() && ways.len() != 1 {
            return Err(Failure::Usage(
                "--out-dir: frames of one way are written: name one --method, --window, --phi and \
                 --depth"
                    .to_owned(),
            ));
        }
        if !self.lose.is_empty() {
            if ways.iter().any(|way| way.method != Method::Sparw) {
                return Err(Failure::Usage(
                    "--lose: only the references of --method sparw can be lost".to_owned(),
                ));
            }
            if self.timing.is_scheduled() && !self.timing.has_server() {
                return Err(Failure::Usage(
                    "--lose: in a schedule a server's references are lost: give --server-ms"
                        .to_owned(),
                ));
            }
        }
        if self.timing.is_asked() && (ways.len() != 1 || ways[0].method != Method::Sparw) {
            return Err(Failure::Usage(
                "--frame-ms, --live: of one way: --method sparw, and one --window, --phi and \
                 --depth"
                    .to_owned(),
            ));
        }
        Ok(())
    }
}
