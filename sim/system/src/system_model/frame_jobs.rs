//! The frames of a path as jobs with dependencies.

use super::compose::Composer;
use super::error::ModelError;
use super::job_scheduler::JobId;
use super::variant::{Frames, Gathering, Scenario, Variant};
use super::work::{FrameWork, PathWork};
use crate::frame_scheduler::{FrameScheduler, Job, REFERENCE_SLOTS, Reference, Windows, unroll};

/// Independent frames under way at the same time: as many as there are buffers for references.
const FRAMES_IN_FLIGHT: usize = REFERENCE_SLOTS;

/// Last jobs of frames under way. A frame begins when the one two before it is shown, as far as units and
/// the feature buffer are free: references of warped paths overlap likewise.
#[derive(Default)]
struct Shown {
    last: [Vec<JobId>; FRAMES_IN_FLIGHT],
    frames: usize,
}

impl Shown {
    /// The next frame, which begins after the given jobs and returns its last.
    fn next(&mut self, frame: impl FnOnce(&[JobId]) -> JobId) {
        let own = &mut self.last[self.frames % FRAMES_IN_FLIGHT];
        *own = vec![frame(own)];
        self.frames += 1;
    }
}

/// The jobs of a frame that is rendered again and again, as those of [`Frames::Full`].
pub(super) fn repeated<'a>(
    mut composer: Composer<'a>,
    (work, gathering): (&FrameWork, Gathering),
    frames: usize,
) -> Composer<'a> {
    composer.in_order();
    let mut shown = Shown::default();
    for rank in 0..frames as u64 {
        shown.next(|before| composer.frame(work, gathering, before, rank));
    }
    composer
}

/// Builds the jobs of a path on a variant.
pub(super) struct FrameJobs<'a> {
    composer: Composer<'a>,
    path: &'a PathWork,
    variant: Variant,
    scenario: Scenario,
}

impl<'a> FrameJobs<'a> {
    pub(super) const fn new(
        composer: Composer<'a>,
        path: &'a PathWork,
        variant: Variant,
        scenario: Scenario,
    ) -> Self {
        Self {
            composer,
            path,
            variant,
            scenario,
        }
    }

    /// The jobs of the path.
    ///
    /// # Errors
    /// A reference whose pose is known too late.
    pub(super) fn jobs(mut self) -> Result<Composer<'a>, ModelError> {
        match self.variant.frames {
            Frames::Full | Frames::Half => self.single(),
            Frames::Warped => self.warped()?,
            Frames::Chained => self.chained(),
        }
        Ok(self.composer)
    }

    /// A full frame, rendered where the scenario has it; a remote reference is sent with its depth.
    fn full(&mut self, work: &FrameWork, with_depth: bool, after: &[JobId], rank: u64) -> JobId {
        let system = self.composer.system();
        let depth = if with_depth {
            system.link_depth_bytes
        } else {
            0.0
        };
        let sent = system.link_colour_bytes + depth;
        match self.scenario {
            Scenario::Local => {
                let gathering = self.variant.gathering;
                self.composer.frame(work, gathering, after, rank)
            }
            Scenario::Remote => self.composer.remote(work, sent, after, rank),
        }
    }

    /// A frame warped from another, with its disoccluded pixels rendered locally.
    fn target(
        &mut self,
        pixels: u64,
        rest: Option<&FrameWork>,
        after: &[JobId],
        rank: u64,
    ) -> JobId {
        let warp = self.composer.warp(pixels, after, rank);
        match rest {
            Some(work) => {
                let gathering = self.variant.gathering;
                self.composer.frame(work, gathering, &[warp], rank)
            }
            None => warp,
        }
    }

    /// Each frame rendered independently.
    fn single(&mut self) {
        let path = self.path;
        self.composer.in_order();
        let mut shown = Shown::default();
        for number in 0..path.targets.len() {
            let (half, rank) = (self.variant.frames == Frames::Half, number as u64);
            let work = match half {
                true => path.half(number),
                false => path.full(number),
            };
            shown.next(|before| {
                let last = self.full(work, false, before, rank);
                if !half {
                    return last;
                }
                let pixels = u64::from(path.size[0]) * u64::from(path.size[1]);
                self.composer.scale(pixels, &[last], rank)
            });
        }
    }

    /// References rendered beside the targets of earlier ones, with the frame scheduler's
    /// dependencies. A target begins when the one before it is shown; a reference begins when its
    /// pose is known and one of two buffers is free.
    fn warped(&mut self) -> Result<(), ModelError> {
        let path = self.path;
        let window = path.options.window as usize;
        let windows = Windows::every(window, path.references.len(), path.targets.len());
        let plan = (path.reference_frames.iter()).map(|(shown_as, known)| Reference {
            known: *known,
            shown_as: *shown_as,
        });
        let frames = FrameScheduler::new(windows, plan.collect(), REFERENCE_SLOTS, false);
        let left = unroll(frames, |job, after, rank| match job {
            Job::Reference(r) | Job::Request(r) | Job::Answer(r) => {
                self.full(&path.references[r], true, after, rank)
            }
            Job::Target(frame) | Job::Fallback(frame) => {
                let target = &path.targets[frame];
                let pixels = target.classes.pixels();
                self.target(pixels, target.work.as_ref(), after, rank)
            }
        });
        match left {
            None => Ok(()),
            Some((frame, reference)) => Err(ModelError::Unfinished { frame, reference }),
        }
    }

    /// Each frame warped from the one before.
    fn chained(&mut self) {
        let path = self.path;
        let mut shown: Vec<JobId> = vec![];
        for (number, frame) in path.chained.iter().enumerate() {
            let rank = number as u64;
            let last = match frame.reference {
                // The frame before as it is: its camera stands still.
                None if frame.classes.rendered == 0 && number > 0 => continue,
                None => self.full(path.full(number), true, &shown, rank),
                Some(_) => {
                    let pixels = frame.classes.pixels();
                    self.target(pixels, frame.work.as_ref(), &shown, rank)
                }
            };
            shown = vec![last];
        }
    }
}
