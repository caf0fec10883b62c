//! Dependencies among the references and targets of a warped path (paper, "Proactive Rendering
//! Runtime").
//!
//! A reference serves a run of frames, its window. It may begin once its pose is known and a slot
//! of the reference buffer is free. The slot is freed when the last frame of the window is
//! rendered. A target may begin once its pose is known and its reference is rendered. The targets
//! of a lost reference, and targets seen from too different an angle, are rendered in full. The
//! most urgent job comes first: the one needed by the earliest frame.
//!
//! [`FrameScheduler`] keeps these rules for both executors. It has neither renderers nor a clock.
//! It is told what happened, and reports which jobs may begin and what they waited for, in
//! *moments* of its user's choice. In [`path_schedule`](crate::path_schedule) a moment is a time in
//! nanoseconds, and each renderer does one frame after the other. In
//! [`system_model`](crate::system_model) a moment is the job at whose end an event happens. Its answers become dependencies of jobs ([`unroll`]),
//! since there parts of several frames overlap on units that share memory.

mod slots;
mod state;
#[cfg(test)]
mod tests;
mod unroll;
mod windows;

use std::collections::{BTreeSet, VecDeque};

use serde::Serialize;

pub(crate) use slots::Hold;
use slots::Slots;
use state::ReferenceState;
pub(crate) use state::{Cause, FrameState};
pub(crate) use unroll::unroll;
pub(crate) use windows::Windows;

/// Slots of the paper's double-buffered reference buffer: one is written while the other is read.
pub(crate) const REFERENCE_SLOTS: usize = 2;

/// A step of rendering a frame or a reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case", tag = "what", content = "number")]
pub enum Job {
    /// Send the request for a reference.
    Request(usize),
    /// Render a reference.
    Reference(usize),
    /// Send a reference back.
    Answer(usize),
    /// Warp a target, and render its disoccluded pixels.
    Target(usize),
    /// Render a target in full.
    Fallback(usize),
}

/// How a frame was produced.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum FrameOrigin {
    /// It is its own reference.
    Reference,
    /// It was warped.
    Warped,
    /// Rendered in full, since an angle was too large.
    FullByAngle,
    /// Rendered in full, since its reference was lost.
    FullByLoss,
}

/// Result of a job.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// Success.
    Right,
    /// A reference was lost, or an angle of a target is too large.
    Failed,
}

/// A reference of a path.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reference {
    /// The frame whose pose makes its own known.
    pub(crate) known: usize,
    /// The frame that shows it, if one does.
    pub(crate) shown_as: Option<usize>,
}

/// The dependency rules as a state machine. Moments must be told in order.
#[derive(Debug)]
pub(crate) struct FrameScheduler<M> {
    windows: Windows,
    plan: Vec<Reference>,
    references: Vec<ReferenceState<M>>,
    frames: Vec<FrameState<M>>,
    slots: Slots<M>,
    /// Whether a remote server renders references.
    is_remote: bool,
    /// The next reference to begin.
    next: usize,
    /// References that the server has still to render, and those it has still to send.
    serve: VecDeque<usize>,
    answer: VecDeque<usize>,
    /// Targets ready to be warped, and those ready to be rendered in full.
    targets: BTreeSet<usize>,
    fallbacks: BTreeSet<usize>,
    /// The next frame to show.
    next_shown: usize,
}

impl<M: Copy + Default + Ord> FrameScheduler<M> {
    /// A path of windows with a reference each. No pose is known yet, and all `slots` are free from
    /// the default moment.
    pub(crate) fn new(
        windows: Windows,
        plan: Vec<Reference>,
        slots: usize,
        is_remote: bool,
    ) -> Self {
        let count = plan.len();
        let references = (0..count).map(|number| ReferenceState {
            readers: windows.of(number).len(),
            ..ReferenceState::default()
        });
        Self {
            references: references.collect(),
            frames: vec![FrameState::default(); windows.frames()],
            windows,
            plan,
            // Slots that no reference is there for are never taken.
            slots: Slots::new(slots.min(count)),
            is_remote,
            next: 0,
            serve: VecDeque::new(),
            answer: VecDeque::new(),
            targets: BTreeSet::new(),
            fallbacks: BTreeSet::new(),
            next_shown: 0,
        }
    }

    /// Jobs that may begin: the most urgent of each kind, references before targets.
    pub(crate) fn ready(&self) -> impl Iterator<Item = Job> + use<M> {
        let reference = self.plan.get(self.next).and_then(|task| {
            self.frames[task.known].pose?;
            self.slots.free()?;
            Some(if self.is_remote {
                Job::Request(self.next)
            } else {
                Job::Reference(self.next)
            })
        });
        let jobs = [
            reference,
            self.serve.front().copied().map(Job::Reference),
            self.answer.front().copied().map(Job::Answer),
            self.targets.first().copied().map(Job::Target),
            self.fallbacks.first().copied().map(Job::Fallback),
        ];
        jobs.into_iter().flatten()
    }

    /// Urgency of a job: the earliest frame that needs it, then references before other jobs.
    pub(crate) fn urgency(&self, job: Job) -> (usize, u8) {
        match job {
            Job::Answer(r) => (self.windows.of(r).start, 0),
            Job::Reference(r) | Job::Request(r) => (self.windows.of(r).start, 1),
            Job::Fallback(frame) => (frame, 2),
            Job::Target(frame) => (frame, 3),
        }
    }

    /// Records that a ready job begins.
    pub(crate) fn begin(&mut self, job: Job, now: M) {
        match job {
            Job::Request(r) | Job::Reference(r) if r == self.next => {
                let free = self.slots.take(r, now);
                self.references[r].slot = free;
                self.next += 1;
            }
            Job::Reference(_) => {
                self.serve.pop_front();
            }
            Job::Answer(_) => {
                self.answer.pop_front();
            }
            Job::Target(frame) => {
                self.targets.remove(&frame);
            }
            Job::Fallback(frame) => {
                self.fallbacks.remove(&frame);
            }
            Job::Request(_) => {}
        }
    }

    /// What a job waited for, its pose first, and the moment each wait ended. A reference or a
    /// request must have begun, and so have a slot.
    pub(crate) fn awaited(&self, job: Job) -> Vec<(Cause, M)> {
        let pose = |frame: usize| self.frames[frame].pose.map(|t| (Cause::Pose, t));
        let of = |r: usize| &self.references[r];
        let all = match job {
            Job::Request(r) | Job::Reference(r) | Job::Answer(r) => {
                let asked = matches!(job, Job::Reference(_) | Job::Answer(_));
                let rendered = matches!(job, Job::Answer(_));
                let (asked, rendered) = (
                    of(r).asked.filter(|_| asked),
                    of(r).rendered.filter(|_| rendered),
                );
                [
                    pose(self.plan[r].known),
                    of(r).slot.map(|(since, _)| (Cause::Buffer, since)),
                    asked.map(|t| (Cause::Link, t)),
                    rendered.map(|t| (Cause::Reference, t)),
                ]
            }
            Job::Target(frame) | Job::Fallback(frame) => {
                let r = of(self.reference_of(frame));
                let refused = self.frames[frame].refused;
                if let (Some(lost), None) = (r.lost, refused) {
                    [pose(frame), Some((Cause::Loss, lost)), None, None]
                } else {
                    // Without a link a reference is there as soon as it is rendered.
                    let sent = r.ready.filter(|_| self.is_remote);
                    [
                        pose(frame),
                        r.rendered.map(|t| (Cause::Reference, t)),
                        sent.map(|t| (Cause::Link, t)),
                        refused.map(|t| (Cause::Angle, t)),
                    ]
                }
            }
        };
        all.into_iter().flatten().collect()
    }

    /// Records that a job has ended. Returns the frame that is finished by it, if any.
    pub(crate) fn end(&mut self, job: Job, now: M, outcome: Outcome) -> Option<usize> {
        match job {
            Job::Reference(r) if !self.is_remote && outcome == Outcome::Failed => {
                self.give_up(r, now);
                None
            }
            Job::Reference(r) => {
                self.references[r].rendered = Some(now);
                if !self.is_remote {
                    return self.arrive(r, now);
                }
                if self.references[r].lost.is_none() {
                    self.answer.push_back(r);
                }
                None
            }
            Job::Target(frame) => {
                let finished = outcome == Outcome::Right;
                if finished {
                    self.frames[frame].finished = Some((now, FrameOrigin::Warped));
                } else {
                    self.frames[frame].refused = Some(now);
                    self.fallbacks.insert(frame);
                }
                self.read(self.reference_of(frame), now);
                finished.then_some(frame)
            }
            Job::Fallback(frame) => {
                let made = match self.frames[frame].refused {
                    Some(_) => FrameOrigin::FullByAngle,
                    None => FrameOrigin::FullByLoss,
                };
                self.frames[frame].finished = Some((now, made));
                Some(frame)
            }
            Job::Request(_) | Job::Answer(_) => None,
        }
    }

    /// Records that the pose of a frame has arrived. Returns the frame if that finishes it: its
    /// reference is the frame itself and was rendered before.
    pub(crate) fn pose(&mut self, frame: usize, now: M) -> Option<usize> {
        self.frames[frame].pose = Some(now);
        self.admit(frame, now).then_some(frame)
    }

    /// Records that a request has arrived at the server.
    pub(crate) fn asked(&mut self, reference: usize, now: M) {
        self.references[reference].asked = Some(now);
        if self.references[reference].lost.is_none() {
            self.serve.push_back(reference);
        }
    }

    /// Records that a reference has arrived in its slot, unless it was given up before. Returns the
    /// frame that it finishes: the one that shows it.
    pub(crate) fn arrive(&mut self, reference: usize, now: M) -> Option<usize> {
        if self.references[reference].lost.is_some() {
            return None;
        }
        self.references[reference].ready = Some(now);
        let mut finished = None;
        for frame in self.windows.of(reference) {
            if self.admit(frame, now) {
                finished = Some(frame);
            }
        }
        finished
    }

    /// Gives up a reference, unless it has arrived. Its jobs that have not begun are dropped.
    pub(crate) fn give_up(&mut self, reference: usize, now: M) {
        if self.references[reference].ready.is_some() {
            return;
        }
        self.references[reference].lost = Some(now);
        self.serve.retain(|r| *r != reference);
        self.answer.retain(|r| *r != reference);
        self.slots.release(reference, now);
        for frame in self.windows.of(reference) {
            self.admit(frame, now);
        }
    }

    /// Queues a frame once its pose is known and its reference is rendered or lost. Returns whether
    /// the frame is finished, being its own reference.
    fn admit(&mut self, frame: usize, now: M) -> bool {
        let r = self.reference_of(frame);
        if self.frames[frame].pose.is_none() {
            return false;
        }
        let state = &self.references[r];
        if state.lost.is_some() {
            self.fallbacks.insert(frame);
        } else if state.ready.is_some() {
            if self.plan[r].shown_as == Some(frame) {
                self.frames[frame].finished = Some((now, FrameOrigin::Reference));
                self.read(r, now);
                return true;
            }
            self.targets.insert(frame);
        }
        false
    }

    /// Records that a target has read its reference. The last of them frees the slot.
    fn read(&mut self, reference: usize, now: M) {
        let readers = &mut self.references[reference].readers;
        *readers -= 1;
        if *readers == 0 {
            self.slots.release(reference, now);
        }
    }

    /// Shows the next frame, if it is finished.
    pub(crate) fn show(&mut self, now: M) -> Option<usize> {
        let next = self.next_shown;
        self.frames.get(next)?.finished?;
        self.frames[next].shown = Some(now);
        self.next_shown += 1;
        Some(next)
    }

    /// Whether all frames have been shown.
    pub(crate) fn is_over(&self) -> bool {
        self.next_shown == self.frames.len()
    }

    /// The next frame to show.
    pub(crate) const fn next_shown(&self) -> usize {
        self.next_shown
    }

    /// The slot of a reference that has begun.
    pub(crate) fn slot(&self, reference: usize) -> Option<usize> {
        self.references[reference].slot.map(|(_, slot)| slot)
    }

    /// The reference that serves a frame.
    pub(crate) fn reference_of(&self, frame: usize) -> usize {
        self.windows.reference_of(frame)
    }

    /// State of a frame.
    pub(crate) fn frame(&self, number: usize) -> &FrameState<M> {
        &self.frames[number]
    }

    /// State of all frames, and the slots that references held.
    pub(crate) fn into_parts(self) -> (Vec<FrameState<M>>, Vec<Hold<M>>) {
        (self.frames, self.slots.into_holds())
    }
}
