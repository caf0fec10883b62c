//! Study of several rendering methods on one path.

use std::time::Instant;

use potamoi_base::camera::Camera;
use potamoi_base::file_keys::Notes;
use potamoi_system::path_schedule::Schedule;
use potamoi_warp::{Counts, Frame, Geometry, Plan, PlanOptions, Rule, Warper};

use super::method::MethodSettings;
use super::quality::{Footage, Measured, Truth};
use super::source::{Depth, Source};
use super::timetable::{Times, Timetable, Timing, given_up};
use super::variant::{Variant, Warping};
use crate::{ExploreError, Progress};

/// A study of several methods on one path.
pub struct Study<'a> {
    /// Source of warping.
    pub source: &'a Source,
    /// Cameras of the frames.
    pub path: &'a [Camera],
    /// Sources of depth; methods refer to them by index.
    pub depths: &'a [Depth],
    /// Frames a second; `None` for a path with its own rate.
    pub fps: Option<f64>,
    /// Timing of references and targets.
    pub timetable: Timetable,
    /// References that never arrive, numbered from 0.
    pub lost: &'a [usize],
}

/// A method with its rule and plan.
#[derive(Debug, Clone)]
pub struct PlannedMethod {
    /// The method.
    pub settings: MethodSettings,
    /// Rule that classifies pixels.
    pub rule: Rule,
    /// Plan of references.
    pub plan: PlanOptions,
}

impl Study<'_> {
    /// Steps of so many methods. A frame that is rendered again, as the schedule lost references,
    /// is a further step.
    #[must_use]
    pub const fn steps(&self, methods: usize) -> u64 {
        (self.path.len() * (methods + 1)) as u64
    }

    /// Renders the frames with each method, and compares them with the model's full frames and with
    /// the ground truth, which is kept for the next representation of the same scene. `show`
    /// receives every frame.
    ///
    /// # Errors
    /// Depth that the source lacks, an invalid rule or plan, frames that cannot be rendered, or an
    /// error of `show`.
    pub fn run<E: From<ExploreError>>(
        &self,
        methods: &[PlannedMethod],
        truth: &mut Truth,
        progress: &dyn Progress,
        show: &mut dyn FnMut(&Frame) -> Result<(), E>,
    ) -> Result<Warping, E> {
        let start = Instant::now();
        let mut notes = Notes::default();
        let mut geometries = vec![];
        for depth in self.depths {
            geometries.push(self.source.geometry(depth, &mut notes)?);
        }
        progress.expect(self.steps(methods.len()));
        let footage = Footage::new(self.source, self.path, truth, progress)?;
        let mut variants = vec![];
        for own in methods {
            let geometry = geometries[own.settings.depth].as_deref();
            variants.push(self.variant(own, geometry, &footage, progress, show)?);
        }
        let mut not_checked = self.source.left_open(self.path);
        not_checked.extend(notes.sentences());
        Ok(Warping {
            scene: self.source.name().to_owned(),
            width: footage.size()[0],
            height: footage.size()[1],
            frames: self.path.len(),
            fps: self.fps,
            model: footage.quality(),
            variants,
            not_checked,
            seconds: start.elapsed().as_secs_f64(),
        })
    }

    fn variant<E: From<ExploreError>>(
        &self,
        own: &PlannedMethod,
        geometry: Option<&dyn Geometry>,
        footage: &Footage,
        progress: &dyn Progress,
        show: &mut dyn FnMut(&Frame) -> Result<(), E>,
    ) -> Result<Variant, E> {
        let PlannedMethod {
            settings,
            rule,
            plan,
        } = own;
        let warper = Warper {
            renderer: self.source.renderer(),
            geometry,
            rule: *rule,
        };
        let plan = Plan::new(self.path, plan).map_err(ExploreError::from)?;
        let count = plan.references.len();
        if let Some(none) = self.lost.iter().find(|n| **n >= count) {
            let expected = match count {
                1 => "0, the only reference of the path".to_owned(),
                count => format!("a reference of the path, 0 to {}", count.saturating_sub(1)),
            };
            let why = format!("--lose {none}: expected {expected}");
            return Err(ExploreError::Refused(why).into());
        }
        let begun = Instant::now();
        let (measured, schedule) = self.frames(settings, warper, &plan, footage, progress, show)?;
        let seconds = begun.elapsed().as_secs_f64();
        let depth = self.depths[settings.depth].to_string();
        let times = &self.timetable.times;
        Ok(Variant {
            timing: schedule
                .as_ref()
                .map(|own| Timing::of(own, times, self.fps)),
            schedule,
            seconds,
            ..Variant::new(settings, depth, measured, &plan, self.path)
        })
    }

    /// Frames of one method with their schedule. References that the schedule gives up are lost to
    /// the frames too, which are then rendered again.
    fn frames<'f, E: From<ExploreError>>(
        &self,
        settings: &MethodSettings,
        warper: Warper<'_>,
        plan: &Plan,
        footage: &'f Footage,
        progress: &dyn Progress,
        show: &mut dyn FnMut(&Frame) -> Result<(), E>,
    ) -> Result<(Measured<'f>, Option<Schedule>), E> {
        let mut lost = self.lost.to_vec();
        loop {
            let mut measured = Measured::new(footage);
            let mut counts = vec![];
            let mut take = |frame: &Frame| -> Result<(), E> {
                measured.add(frame);
                counts.push(Counts::of(&frame.target.classes, |_| true));
                show(frame)?;
                progress.advance(1);
                Ok(())
            };
            let times = match &self.timetable.times {
                Times::Measured => {
                    let mut failed = None;
                    let timetable = &self.timetable;
                    let schedule = timetable.measure(warper, self.path, plan, &lost, |frame| {
                        if failed.is_none() {
                            failed = take(&frame).err();
                        }
                    })?;
                    return failed.map_or(Ok((measured, Some(schedule))), Err);
                }
                Times::Given(times) => Some(times),
                Times::None => None,
            };
            for frame in settings.frames(warper, self.path, plan, &lost) {
                take(&frame.map_err(ExploreError::from)?)?;
            }
            let Some(times) = times else {
                return Ok((measured, None));
            };
            let camera = &self.path[0];
            let schedule =
                (self.timetable).schedule(times, plan, &counts, camera, self.fps, &lost)?;
            let before = lost.len();
            let late = given_up(&schedule).into_iter();
            lost.extend(late.filter(|n| !self.lost.contains(n)));
            lost.sort_unstable();
            lost.dedup();
            if lost.len() == before {
                return Ok((measured, Some(schedule)));
            }
            progress.expect(self.path.len() as u64);
        }
    }
}
