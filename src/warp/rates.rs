//! One scene at several frame rates, beside its own path if its camera follows a recorded motion.

use indicatif::ProgressBar;
use potamoi_explore::warping::{Pace, RateRow, Rates, Source, Truth};
use schemars::JsonSchema;
use serde::Serialize;

use super::report::FORMAT_VERSION;
use super::{WarpArgs, source};
use crate::failure::Failure;
use crate::scene::say_not_checked;
use crate::stdout::say;
use crate::tables;

#[derive(Serialize, JsonSchema)]
pub(super) struct Report {
    format_version: u32,
    command: &'static str,
    #[serde(flatten)]
    found: Rates,
}

impl WarpArgs {
    /// Warps the scene at every rate, and prints one table.
    pub(super) fn at_rates(&self, bar: &ProgressBar) -> Result<(), Failure> {
        self.check_rates()?;
        let name = self.scene.name();
        let own = source::open(&self.scene, name)?;
        if !own.is_timed() {
            return Err(Failure::Usage(format!(
                "--fps: expected one rate, as the frames of {name} have a rate of their own or none"
            )));
        }
        let beside = own.without_motion();
        let mut paths: Vec<(&'static str, &Source)> = vec![];
        match &beside {
            Some(orbit) => paths.extend([("trajectory", &own), ("orbit", orbit)]),
            None => paths.push(("orbit", &own)),
        }
        let mut all = Rates {
            scene: own.name().to_owned(),
            width: 0,
            height: 0,
            rates: vec![],
            not_checked: vec![],
        };
        for fps in &self.fps {
            for (path, source) in &paths {
                bar.set_message(format!("{path} at {fps} frames a second"));
                self.row(path, *fps, (source, &own), &mut all, bar)?;
            }
        }
        bar.finish_and_clear();
        print(&all, self.timing.is_scheduled());
        self.files.write(&Report {
            format_version: FORMAT_VERSION,
            command: "warp",
            found: all,
        })
    }

    /// Adds the rows of one path at one rate. The motion is as long as that of `timed`.
    fn row(
        &self,
        path: &'static str,
        fps: f64,
        (source, timed): (&Source, &Source),
        all: &mut Rates,
        bar: &ProgressBar,
    ) -> Result<(), Failure> {
        let usual = 3 * self.methods.longest_window();
        let length = timed.length(fps);
        let frames = self.frames.unwrap_or(usual);
        let frames = length.map_or(frames, |length| frames.min(length));
        let cameras = source.path(fps, Some(frames), usual)?;
        let motion = source.path(fps, Some(length.unwrap_or(frames)), usual)?;
        let found = self.along(source, &cameras, fps, &mut Truth::default(), bar)?;
        let pace = Pace {
            path,
            fps,
            frames: &cameras,
            motion: &motion,
        };
        let timetable = self.timing.timetable();
        for (variant, planned) in found.variants.iter().zip(self.planned(source)?) {
            let row = RateRow::of(&pace, &found, variant, &planned.plan, &timetable);
            all.rates.push(row?);
        }
        [all.width, all.height] = [found.width, found.height];
        for sentence in found.not_checked {
            if !all.not_checked.contains(&sentence) {
                all.not_checked.push(sentence);
            }
        }
        Ok(())
    }

    /// Refuses options that apply to a single rate only.
    fn check_rates(&self) -> Result<(), Failure> {
        let single = [
            ("--scenes", !self.scenes.is_empty()),
            ("--out-dir", self.out_dir.is_some()),
            ("--chrome-trace", self.timing.chrome_trace.is_some()),
            ("--live", self.timing.is_live()),
            ("--lose", !self.lose.is_empty()),
        ];
        match single.iter().find(|(_, given)| *given) {
            Some((flag, _)) => Err(Failure::Usage(format!(
                "{flag}: expected one rate: name one --fps"
            ))),
            None => Ok(()),
        }
    }
}

fn number(value: Option<f64>, digits: usize) -> String {
    value.map_or_else(|| "-".to_owned(), |v| format!("{v:.digits$}"))
}

fn print(all: &Rates, is_scheduled: bool) {
    say!("{}: {} x {}", all.scene, all.width, all.height);
    let mut table = tables::lined(
        2,
        [
            "frames a second",
            "path",
            "method",
            "frames",
            "PSNR to model, dB",
            "PSNR to truth, dB",
            "rendered in total %",
            "predicted references",
            "prediction error, degrees",
            "at most",
            "standing still",
            "units of the scene",
            "deadline misses",
            "no miss up to, ms",
        ],
    );
    for row in &all.rates {
        let prediction = row.prediction.as_ref();
        table.add_row([
            row.fps.to_string(),
            row.path.to_owned(),
            row.method.clone(),
            row.frames.to_string(),
            number(row.psnr_to_model_db, 2),
            number(row.psnr_to_truth_db, 2),
            format!("{:.1}", 100.0 * row.rendered_share),
            prediction.map_or_else(|| "-".to_owned(), |p| p.references.to_string()),
            number(prediction.map(|p| p.mean_degrees), 3),
            number(prediction.map(|p| p.largest_degrees), 3),
            number(prediction.map(|p| p.still_degrees), 3),
            number(prediction.map(|p| p.mean_distance), 4),
            number(row.deadline_misses.map(|n| n as f64), 0),
            number(row.no_miss_up_to_ms, 2),
        ]);
    }
    say!("{}", tables::fitted(&table, &[]));
    say!(
        "  prediction error: of the references of the whole motion, on average and at most; standing \
         still: the same with the last known pose; units of the scene: distance, on average"
    );
    say!(
        "  deadline misses: frames not shown within a frame's time of their pose{}",
        match is_scheduled {
            true => "",
            false => "; give the time of a full frame, --frame-ms",
        }
    );
    say!(
        "  no miss up to: the longest time of a full frame with which no frame behind the first \
         window is late"
    );
    if all.rates.iter().any(|row| row.path == "orbit") {
        say!(
            "  orbit: the scene's own path, which is a circle at 36 degrees a second where a model \
             has none"
        );
    }
    say_not_checked(&all.not_checked);
}
