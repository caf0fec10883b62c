//! When references and targets are rendered: scheduled by times that are given,
//! or measured.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;
use potamoi_base::camera::Camera;
use potamoi_system::link;
use potamoi_system::runtime::{
    Link, LinkUse, Made, Nanos, Options, PixelClock, Poses, References, Remote, Resource, Schedule,
    chrome_trace, live, schedule,
};
use potamoi_warp::{Counts, Frame, Plan, Shaded, WarpError, Warper};
use serde::Serialize;

use crate::failure::Failure;
use crate::files;
use crate::stdout::say;

const NANOS_A_MILLISECOND: f64 = 1e6;

/// Options of the runtime.
#[derive(Debug, Args)]
pub(super) struct TimingArgs {
    /// Time of a full frame, with which frames are scheduled; a target takes the share that it
    /// renders [default: no schedule]
    #[arg(long, value_name = "MS", conflicts_with = "live")]
    frame_ms: Option<f64>,
    /// Time of warping a reference to a target [default: 0, which the report notes]
    #[arg(long, value_name = "MS", requires = "frame_ms")]
    warp_ms: Option<f64>,
    /// Time in which a server renders a reference, sent over the paper's wireless link of 10 MB/s
    /// [default: references are rendered on the device]
    #[arg(long, value_name = "MS", requires = "frame_ms")]
    server_ms: Option<f64>,
    /// Time after which a reference from the server is given up
    #[arg(
        long,
        value_name = "MS",
        default_value_t = 1000.0,
        requires = "server_ms"
    )]
    timeout_ms: f64,
    /// Let references and targets share one renderer
    #[arg(long)]
    one_renderer: bool,
    /// Render references and targets at once, on two threads, and measure
    #[arg(long)]
    live: bool,
    /// Schedule as a Chrome trace, for Perfetto; of several variants, that of the last
    #[arg(long, value_name = "FILE")]
    pub(super) chrome_trace: Option<PathBuf>,
}

/// References that are rendered here, less those that are lost.
struct Here<'a> {
    warper: Warper<'a>,
    lost: &'a [usize],
}

impl References for Here<'_> {
    fn reference(&self, number: usize, camera: &Camera) -> Result<Option<Shaded>, WarpError> {
        if self.lost.contains(&number) {
            return Ok(None);
        }
        self.warper.reference(camera).map(Some)
    }
}

/// What a schedule comes to.
#[derive(Serialize)]
pub(super) struct Timing {
    /// "given" or "measured".
    times: &'static str,
    /// No time was given for warping, which was taken to be done at once.
    warping_is_free: bool,
    frames_per_second: Option<f64>,
    span_ms: f64,
    latency_mean_ms: f64,
    latency_max_ms: f64,
    /// While a reference and a target were rendered at once.
    overlap_ms: f64,
    /// What frames waited for.
    waits_ms: Vec<(&'static str, f64)>,
    /// Of the span, how long each was busy.
    utilisation: Vec<(&'static str, f64)>,
    link: LinkUse,
}

impl TimingArgs {
    /// Whether anything is asked for.
    pub(super) const fn is_asked(&self) -> bool {
        self.is_live() || self.is_scheduled()
    }

    /// Whether frames are really rendered at once.
    pub(super) const fn is_live(&self) -> bool {
        self.live
    }

    /// Whether references come from a server, in the schedule.
    pub(super) const fn has_server(&self) -> bool {
        self.server_ms.is_some()
    }

    /// Whether times are given.
    pub(super) const fn is_scheduled(&self) -> bool {
        self.frame_ms.is_some()
    }

    pub(super) fn check(&self) -> Result<(), Failure> {
        let options = [
            ("--frame-ms", self.frame_ms),
            ("--warp-ms", self.warp_ms),
            ("--server-ms", self.server_ms),
            ("--timeout-ms", Some(self.timeout_ms)),
        ];
        for (name, value) in options {
            let fits = |v: f64| (0.0..=1e9).contains(&v);
            if let Some(value) = value.filter(|v| !fits(*v)) {
                return Err(Failure::Usage(format!(
                    "{name} {value}: expected 0 to 1e9 milliseconds"
                )));
            }
        }
        if self.live && (self.server_ms.is_some() || self.warp_ms.is_some()) {
            return Err(Failure::Usage(
                "--live: really renders, here, and measures: leave out --server-ms, --timeout-ms \
                 and --warp-ms, or schedule with --frame-ms"
                    .to_owned(),
            ));
        }
        if self.chrome_trace.is_some() && !self.is_asked() {
            return Err(Failure::Usage(
                "--chrome-trace: of a schedule: give --frame-ms, or --live to measure".to_owned(),
            ));
        }
        Ok(())
    }

    fn options(&self, fps: Option<f64>) -> Options {
        // To a thousandth of a frame a second.
        let poses = fps.map_or(Poses::OnShown, |fps| Poses::Rate {
            frames: (fps * 1000.0).round() as u32,
            seconds: 1000,
        });
        Options {
            concurrent: !self.one_renderer,
            ..Options::new(poses)
        }
    }

    /// Schedules by the times that were given.
    pub(super) fn schedule(
        &self,
        plan: &Plan,
        counts: &[Counts],
        camera: &Camera,
        fps: Option<f64>,
        lost: &[usize],
    ) -> Result<Schedule, Failure> {
        let nanos = |ms: f64| (ms * NANOS_A_MILLISECOND).round() as Nanos;
        let clock = PixelClock {
            frame: nanos(self.frame_ms.unwrap_or_default()),
            served: nanos(self.server_ms.unwrap_or_default()),
            warp: nanos(self.warp_ms.unwrap_or_default()),
        };
        let remote = self.server_ms.map(|_| Remote {
            link: Link::PAPER,
            request_bytes: link::REQUEST_BYTES,
            reference_bytes: u64::from(link::REFERENCE_BYTES)
                * u64::from(camera.width)
                * u64::from(camera.height),
            timeout: nanos(self.timeout_ms),
            lost: lost.iter().copied().collect::<BTreeSet<_>>(),
        });
        Ok(schedule(
            plan,
            counts,
            &clock,
            &self.options(fps),
            remote.as_ref(),
        )?)
    }

    /// Renders on threads, and measures; `show` takes the frames.
    pub(super) fn measure(
        &self,
        warper: Warper<'_>,
        path: &[Camera],
        plan: &Plan,
        lost: &[usize],
        show: impl FnMut(Frame),
    ) -> Result<Schedule, Failure> {
        let options = self.options(None);
        let here = Here { warper, lost };
        Ok(live(warper, &here, path, plan, &options, show)?)
    }

    /// References that a schedule gave up.
    pub(super) fn given_up(schedule: &Schedule) -> BTreeSet<usize> {
        let lost = schedule
            .frames
            .iter()
            .filter(|f| f.made == Made::FullByLoss);
        lost.map(|f| f.reference).collect()
    }

    /// Sums up, and writes the trace.
    pub(super) fn done(&self, schedule: &Schedule) -> Result<Timing, Failure> {
        if let Some(path) = &self.chrome_trace {
            files::write_json(path, &chrome_trace(schedule))?;
        }
        let ms = |nanos: Nanos| nanos as f64 / NANOS_A_MILLISECOND;
        let totals = &schedule.totals;
        let waits = totals.frame_waits.named();
        Ok(Timing {
            times: if self.live { "measured" } else { "given" },
            warping_is_free: !self.live && self.warp_ms.is_none(),
            frames_per_second: totals.frames_per_second,
            span_ms: ms(totals.span),
            latency_mean_ms: ms(totals.latency_mean),
            latency_max_ms: ms(totals.latency_max),
            overlap_ms: ms(totals.overlap),
            waits_ms: waits.map(|(name, time)| (name, ms(time))).to_vec(),
            utilisation: Resource::ALL
                .into_iter()
                .filter_map(|r| Some((r.name(), schedule.utilisation(r)?)))
                .collect(),
            link: totals.link,
        })
    }
}

impl Timing {
    pub(super) fn print(&self, name: &str, trace: Option<&PathBuf>) {
        say!(
            "  {name}, by times that are {}: {:.1} ms in all, {} frames a second; a frame is there \
             {:.1} ms after its pose on average, {:.1} at most; references and targets were \
             rendered at once for {:.1} ms",
            self.times,
            self.span_ms,
            self.frames_per_second
                .map_or_else(|| "-".to_owned(), |fps| format!("{fps:.1}")),
            self.latency_mean_ms,
            self.latency_max_ms,
            self.overlap_ms
        );
        if self.warping_is_free {
            say!("    warping was taken to need no time: --warp-ms says otherwise");
        }
        let list = |parts: &[(&str, f64)], unit: &str, scale: f64| {
            let parts = parts.iter().filter(|(_, value)| *value > 0.0);
            let parts = parts.map(|(name, value)| format!("{name} {:.1}{unit}", scale * value));
            parts.collect::<Vec<_>>().join(", ")
        };
        say!(
            "    frames waited for: {}",
            list(&self.waits_ms, " ms", 1.0)
        );
        say!("    busy: {}", list(&self.utilisation, " %", 100.0));
        if self.link.bytes > 0 {
            say!(
                "    over the link: {:.2} MB, {:.1} mJ (the paper's 100 nJ/B)",
                self.link.bytes as f64 / 1e6,
                self.link.nanojoules as f64 / 1e6
            );
        }
        if let Some(path) = trace {
            say!("    trace for Perfetto: {}", path.display());
        }
    }
}
