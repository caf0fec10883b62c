//! Which references and targets of a warped path may be rendered when (paper, "Proactive
//! Rendering Runtime").
//!
//! A reference serves a run of frames, its window. It may begin when its pose is known and a slot
//! of the reference buffer is free; a slot is free again when the last frame of the window that
//! held it is made. A target may begin when its pose is known and its reference is there. A
//! reference that is lost, or seen from too different an angle, has its targets rendered in full.
//! What a frame needs soonest comes first.
//!
//! [`FrameScheduler`] keeps these rules for all who render a path. It has neither renderers nor a
//! clock. It is told what happened, and says what may begin and what that had to wait for, in
//! *moments* of its user's choice: [`runtime`](crate::runtime) tells it nanoseconds, as one
//! renderer after the other does a frame; [`soc`](crate::soc) tells it the job at whose end
//! something is so, and makes dependencies of the answers ([`unroll`]), since there parts of several frames
//! overlap on units that share memory.

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

/// References that the paper's buffer holds: one is written while the other is read.
pub(crate) const REFERENCE_SLOTS: usize = 2;

/// What is done for a frame or a reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case", tag = "what", content = "number")]
pub enum Job {
    /// A reference is asked for.
    Request(usize),
    /// A reference is rendered.
    Reference(usize),
    /// A reference is sent back.
    Answer(usize),
    /// A target is warped, and rendered where its reference does not show it.
    Target(usize),
    /// A target is rendered in full.
    Fallback(usize),
}

/// How a frame came about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Made {
    /// It is the reference.
    Reference,
    /// It was warped.
    Warped,
    /// It was rendered in full, as an angle was too large.
    FullByAngle,
    /// It was rendered in full, as its reference was lost.
    FullByLoss,
}

/// How a job went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// As it should.
    Right,
    /// A reference was lost; of a target an angle is too large.
    Failed,
}

/// A reference of a path.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reference {
    /// The frame at whose pose its own is known.
    pub(crate) known: usize,
    /// The frame as which it is shown, if it is one.
    pub(crate) shown_as: Option<usize>,
}

/// The rules, as a state machine. Moments have to be told in order.
#[derive(Debug)]
pub(crate) struct FrameScheduler<M> {
    windows: Windows,
    plan: Vec<Reference>,
    references: Vec<ReferenceState<M>>,
    frames: Vec<FrameState<M>>,
    slots: Slots<M>,
    /// Whether a server renders references, at the other end of a link.
    is_remote: bool,
    /// The reference that is begun next.
    next: usize,
    /// References that the server is to render, and that it is to send.
    serve: VecDeque<usize>,
    answer: VecDeque<usize>,
    /// Targets to be warped, and to be rendered in full.
    targets: BTreeSet<usize>,
    fallbacks: BTreeSet<usize>,
    /// The frame that is shown next.
    next_shown: usize,
}

impl<M: Copy + Default + Ord> FrameScheduler<M> {
    /// A path of windows, a reference for each. Of no pose is known yet, and all of `slots` are
    /// free since the default moment.
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

    /// What may begin: of each kind of job the first, references before targets.
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

    /// The frame that needs a job soonest; a reference before what else that frame needs.
    pub(crate) fn urgency(&self, job: Job) -> (usize, u8) {
        match job {
            Job::Answer(r) => (self.windows.of(r).start, 0),
            Job::Reference(r) | Job::Request(r) => (self.windows.of(r).start, 1),
            Job::Fallback(frame) => (frame, 2),
            Job::Target(frame) => (frame, 3),
        }
    }

    /// A job that is ready begins.
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

    /// What a job had to wait for, its pose first, and when that came. Asked for a reference or
    /// a request, it has to have begun, and so to have a slot.
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

    /// A job has ended. The frame that is finished by it, if one is.
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
                    self.frames[frame].finished = Some((now, Made::Warped));
                } else {
                    self.frames[frame].refused = Some(now);
                    self.fallbacks.insert(frame);
                }
                self.read(self.reference_of(frame), now);
                finished.then_some(frame)
            }
            Job::Fallback(frame) => {
                let made = match self.frames[frame].refused {
                    Some(_) => Made::FullByAngle,
                    None => Made::FullByLoss,
                };
                self.frames[frame].finished = Some((now, made));
                Some(frame)
            }
            Job::Request(_) | Job::Answer(_) => None,
        }
    }

    /// The pose of a frame has arrived. The frame, if it is finished by that: its reference is it,
    /// and was there before.
    pub(crate) fn pose(&mut self, frame: usize, now: M) -> Option<usize> {
        self.frames[frame].pose = Some(now);
        self.admit(frame, now).then_some(frame)
    }

    /// A request has arrived at the server.
    pub(crate) fn asked(&mut self, reference: usize, now: M) {
        self.references[reference].asked = Some(now);
        if self.references[reference].lost.is_none() {
            self.serve.push_back(reference);
        }
    }

    /// A reference has arrived in its slot, unless it was given up before. The frame that is
    /// finished by it: that which it is.
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

    /// A reference is given up, unless it is there: what was not begun for it is not begun any
    /// more.
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

    /// Queues a frame if its pose and its reference are there, or the latter is lost. Whether it
    /// is finished, as it is its reference.
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
                self.frames[frame].finished = Some((now, Made::Reference));
                self.read(r, now);
                return true;
            }
            self.targets.insert(frame);
        }
        false
    }

    /// A target has read its reference; the last of them frees its slot.
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

    /// Whether all frames were shown.
    pub(crate) fn is_over(&self) -> bool {
        self.next_shown == self.frames.len()
    }

    /// The frame that is shown next.
    pub(crate) const fn next_shown(&self) -> usize {
        self.next_shown
    }

    /// The slot of a reference that was begun.
    pub(crate) fn slot(&self, reference: usize) -> Option<usize> {
        self.references[reference].slot.map(|(_, slot)| slot)
    }

    /// The reference that serves a frame.
    pub(crate) fn reference_of(&self, frame: usize) -> usize {
        self.windows.reference_of(frame)
    }

    /// What is known of a frame.
    pub(crate) fn frame(&self, number: usize) -> &FrameState<M> {
        &self.frames[number]
    }

    /// What is known of all frames, and which references held which slots.
    pub(crate) fn into_parts(self) -> (Vec<FrameState<M>>, Vec<Hold<M>>) {
        (self.frames, self.slots.into_holds())
    }
}
