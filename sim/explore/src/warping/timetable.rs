//! Timing of references and targets: scheduled by given times, or measured.

use std::collections::BTreeSet;

use potamoi_base::camera::Camera;
use potamoi_system::link;
use potamoi_system::path_schedule::{
    FrameOrigin, Link, LinkUse, Nanos, Options, PixelClock, Poses, References, Remote, Resource,
    Schedule, live, schedule,
};
use potamoi_warp::{Counts, Frame, Plan, Shaded, WarpError, Warper};
use schemars::JsonSchema;
use serde::Serialize;

use crate::ExploreError;

const NANOS_A_MILLISECOND: f64 = 1e6;

/// Timing options of references and targets.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Timetable {
    /// Source of times.
    pub times: Times,
    /// Whether references and targets share a renderer.
    pub one_renderer: bool,
}

/// Source of times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Times {
    /// None: frames are not scheduled.
    None,
    /// Given: frames are scheduled by these times.
    Given(GivenTimes),
    /// Measured: references and targets are rendered on two threads.
    Measured,
}

/// Given times in milliseconds, none negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GivenTimes {
    /// Full frame; a target takes the share that it renders.
    pub frame: f64,
    /// Warping a reference to a target; `None`: 0, which the report notes.
    pub warp: Option<f64>,
    /// Reference on a server, sent over the paper's link; `None`: references are rendered on the
    /// device.
    pub server: Option<f64>,
    /// Timeout of a reference from the server.
    pub timeout: f64,
}

/// References rendered locally, without lost ones.
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

/// Summary of a schedule.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Timing {
    /// Source of times: "given" or "measured".
    pub times: &'static str,
    /// Whether no warping time was given, so that warping took 0.
    pub warping_is_free: bool,
    /// Frames a second over the span; `None` for a span of 0.
    pub frames_per_second: Option<f64>,
    /// Milliseconds from the first pose to the last frame.
    pub span_ms: f64,
    /// Mean latency of a frame from its pose, in milliseconds.
    pub latency_mean_ms: f64,
    /// Largest latency, in milliseconds.
    pub latency_max_ms: f64,
    /// Frames that were not shown within a frame's time of their pose; `None` where poses have no
    /// rate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deadline_misses: Option<usize>,
    /// Milliseconds in which a reference and a target were rendered at once.
    pub overlap_ms: f64,
    /// Waits of frames by cause, in milliseconds.
    pub waits_ms: Vec<(&'static str, f64)>,
    /// Utilisation of each resource, from 0 to 1.
    pub utilisation: Vec<(&'static str, f64)>,
    /// Traffic on the link.
    pub link: LinkUse,
}

/// Numbers of the frames of a schedule that were not shown within a frame's time of their pose, at
/// `fps` frames a second. Poses come at times rounded to a nanosecond.
pub(super) fn late_frames(schedule: &Schedule, fps: f64) -> impl Iterator<Item = usize> {
    let most = (1e9 / fps).ceil();
    let frames = schedule.frames.iter();
    let late = frames.filter(move |frame| (frame.shown - frame.pose) as f64 > most);
    late.map(|frame| frame.number)
}

impl Timetable {
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

    /// Schedules by given times.
    pub(super) fn schedule(
        &self,
        times: &GivenTimes,
        plan: &Plan,
        counts: &[Counts],
        camera: &Camera,
        fps: Option<f64>,
        lost: &[usize],
    ) -> Result<Schedule, ExploreError> {
        let nanos = |ms: f64| (ms * NANOS_A_MILLISECOND).round() as Nanos;
        let clock = PixelClock {
            frame: nanos(times.frame),
            served: nanos(times.server.unwrap_or_default()),
            warp: nanos(times.warp.unwrap_or_default()),
        };
        let remote = times.server.map(|_| Remote {
            link: Link::PAPER,
            request_bytes: link::REQUEST_BYTES,
            reference_bytes: u64::from(link::REFERENCE_BYTES)
                * u64::from(camera.width)
                * u64::from(camera.height),
            timeout: nanos(times.timeout),
            lost: lost.iter().copied().collect::<BTreeSet<_>>(),
        });
        let options = self.options(fps);
        Ok(schedule(plan, counts, &clock, &options, remote.as_ref())?)
    }

    /// Renders on threads and measures; `show` receives the frames.
    pub(super) fn measure(
        &self,
        warper: Warper<'_>,
        path: &[Camera],
        plan: &Plan,
        lost: &[usize],
        show: impl FnMut(Frame),
    ) -> Result<Schedule, ExploreError> {
        let options = self.options(None);
        let here = Here { warper, lost };
        Ok(live(warper, &here, path, plan, &options, show)?)
    }
}

/// References that a schedule gave up.
pub(super) fn given_up(schedule: &Schedule) -> BTreeSet<usize> {
    let lost = schedule
        .frames
        .iter()
        .filter(|f| f.made == FrameOrigin::FullByLoss);
    lost.map(|f| f.reference).collect()
}

impl Timing {
    /// Summary of a schedule for a source of times.
    pub(super) fn of(schedule: &Schedule, times: &Times, fps: Option<f64>) -> Self {
        let ms = |nanos: Nanos| nanos as f64 / NANOS_A_MILLISECOND;
        let totals = &schedule.totals;
        let waits = totals.frame_waits.named();
        Self {
            times: match times {
                Times::Measured => "measured",
                _ => "given",
            },
            warping_is_free: matches!(times, Times::Given(GivenTimes { warp: None, .. })),
            frames_per_second: totals.frames_per_second,
            span_ms: ms(totals.span),
            latency_mean_ms: ms(totals.latency_mean),
            latency_max_ms: ms(totals.latency_max),
            // What is measured has the poses of what was shown.
            deadline_misses: fps
                .filter(|_| matches!(times, Times::Given(_)))
                .map(|fps| late_frames(schedule, fps).count()),
            overlap_ms: ms(totals.overlap),
            waits_ms: waits.map(|(name, time)| (name, ms(time))).to_vec(),
            utilisation: Resource::ALL
                .into_iter()
                .filter_map(|r| Some((r.name(), schedule.utilisation(r)?)))
                .collect(),
            link: totals.link,
        }
    }
}
