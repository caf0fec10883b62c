//! The dispatcher: what may begin, and what begins (paper, "Scheduler").

use std::collections::{BTreeSet, VecDeque};

use potamoi_warp::Plan;

use super::buffer::Buffer;
use super::finish::Record;
use super::state::{Cause, FrameState, Gates, ReferenceState, split};
use super::windows;
use super::{Job, Made, Nanos, Options, Resource, RuntimeError, Task};
use crate::frame_rules::Windows;

/// How a job went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    /// As it should.
    Right,
    /// A reference was lost; of a target an angle is too large.
    Failed,
}

#[derive(Debug, Clone)]
struct Running {
    job: Job,
    start: Nanos,
    gates: Gates,
    free_since: Nanos,
}

/// A state machine that is told what happens when, and says what begins. It has
/// no clock: times are only recorded, and have to be told in order.
#[derive(Debug)]
pub(super) struct Dispatcher<'p> {
    plan: &'p Plan,
    windows: Windows,
    concurrent: bool,
    remote: bool,
    references: Vec<ReferenceState>,
    frames: Vec<FrameState>,
    buffer: Buffer,
    /// The reference that is begun next.
    next: usize,
    /// References that the server is to render, and that it is to send.
    serve: VecDeque<usize>,
    answer: VecDeque<usize>,
    /// Targets to be warped, and to be rendered in full.
    targets: BTreeSet<usize>,
    fallbacks: BTreeSet<usize>,
    running: [Option<Running>; Resource::ALL.len()],
    free_since: [Nanos; Resource::ALL.len()],
    /// The frame that is shown next.
    next_shown: usize,
    tasks: Vec<Task>,
}

impl<'p> Dispatcher<'p> {
    pub(super) fn new(
        plan: &'p Plan,
        options: &Options,
        remote: bool,
    ) -> Result<Self, RuntimeError> {
        options.check()?;
        let windows = windows::checked(plan, options.poses)?;
        let count = plan.references.len();
        let references = (0..count).map(|number| ReferenceState {
            readers: windows.of(number).len(),
            ..ReferenceState::default()
        });
        Ok(Self {
            plan,
            references: references.collect(),
            windows,
            concurrent: options.concurrent,
            remote,
            frames: vec![FrameState::default(); plan.targets.len()],
            // Slots that no reference is there for are never taken.
            buffer: Buffer::new(options.slots.min(count)),
            next: 0,
            serve: VecDeque::new(),
            answer: VecDeque::new(),
            targets: BTreeSet::new(),
            fallbacks: BTreeSet::new(),
            running: [const { None }; Resource::ALL.len()],
            free_since: [0; Resource::ALL.len()],
            next_shown: 0,
            tasks: vec![],
        })
    }

    /// The resources that there are.
    pub(super) fn resources(&self) -> Vec<Resource> {
        let all = Resource::ALL.into_iter();
        all.filter(|r| match r {
            Resource::Full | Resource::Sparse => self.concurrent,
            Resource::Shared => !self.concurrent,
            Resource::Server | Resource::Link => self.remote,
        })
        .collect()
    }

    fn resource(&self, job: Job) -> Resource {
        match job {
            Job::Request(_) | Job::Answer(_) => Resource::Link,
            Job::Reference(_) if self.remote => Resource::Server,
            _ if !self.concurrent => Resource::Shared,
            Job::Reference(_) | Job::Fallback(_) => Resource::Full,
            Job::Target(_) => Resource::Sparse,
        }
    }

    fn window(&self, frame: usize) -> usize {
        self.plan.targets[frame].reference
    }

    /// The frame that needs a job soonest; a reference before what else that
    /// frame needs.
    fn urgency(&self, job: Job) -> (usize, u8) {
        match job {
            Job::Answer(r) => (self.windows.of(r).start, 0),
            Job::Reference(r) | Job::Request(r) => (self.windows.of(r).start, 1),
            Job::Fallback(frame) => (frame, 2),
            Job::Target(frame) => (frame, 3),
        }
    }

    /// What a resource, if it is free, could begin.
    fn ready_for(&self, resource: Resource) -> Option<Job> {
        if self.running[resource as usize].is_some() {
            return None;
        }
        let reference = self.plan.references.get(self.next).and_then(|task| {
            self.frames[task.known].pose?;
            self.buffer.free()?;
            Some(if self.remote {
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
        let jobs = jobs.into_iter().flatten();
        jobs.filter(|job| self.resource(*job) == resource)
            .min_by_key(|job| self.urgency(*job))
    }

    /// Begins what a resource has to do, if it is free and there is something.
    pub(super) fn begin(&mut self, resource: Resource, now: Nanos) -> Option<Job> {
        let job = self.ready_for(resource)?;
        match job {
            Job::Request(r) | Job::Reference(r) if r == self.next => {
                let free = self.buffer.free()?;
                self.buffer.take(free.1, r, now);
                self.references[r].slot = Some(free);
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
        self.running[resource as usize] = Some(Running {
            job,
            start: now,
            gates: self.gates(job),
            free_since: self.free_since[resource as usize],
        });
        Some(job)
    }

    /// What a job had to wait for, its pose first.
    fn gates(&self, job: Job) -> Gates {
        let pose = |frame: usize| self.frames[frame].pose.map(|t| (Cause::Pose, t));
        let of = |r: usize| &self.references[r];
        let all = match job {
            Job::Request(r) | Job::Reference(r) | Job::Answer(r) => {
                let asked = matches!(job, Job::Reference(_) | Job::Answer(_));
                let rendered = matches!(job, Job::Answer(_));
                [
                    pose(self.plan.references[r].known),
                    of(r).slot.map(|(since, _)| (Cause::Buffer, since)),
                    of(r).asked.filter(|_| asked).map(|t| (Cause::Link, t)),
                    of(r)
                        .rendered
                        .filter(|_| rendered)
                        .map(|t| (Cause::Reference, t)),
                ]
            }
            Job::Target(frame) | Job::Fallback(frame) => {
                let r = of(self.window(frame));
                let refused = self.frames[frame].refused;
                let last = refused.map(|t| (Cause::Angle, t));
                if let (Some(lost), None) = (r.lost, refused) {
                    [pose(frame), Some((Cause::Loss, lost)), None, None]
                } else {
                    let rendered = r.rendered.map(|t| (Cause::Reference, t));
                    [
                        pose(frame),
                        rendered,
                        r.ready.map(|t| (Cause::Link, t)),
                        last,
                    ]
                }
            }
        };
        all.into_iter().flatten().collect()
    }

    /// The job of a resource has ended.
    pub(super) fn end(&mut self, resource: Resource, now: Nanos, outcome: Outcome) {
        let Some(running) = self.running[resource as usize].take() else {
            return;
        };
        let Running {
            job,
            start,
            gates,
            free_since,
        } = running;
        self.free_since[resource as usize] = now;
        let rest = match resource {
            Resource::Link => Cause::Link,
            _ => Cause::Renderer,
        };
        let asked = gates.first().map_or(start, |gate| gate.1);
        let waits = split(asked, &gates, start, rest);
        self.tasks.push(Task {
            job,
            resource,
            asked,
            start,
            end: now,
            waits,
            idle: split(free_since, &gates, start, rest),
            slot: match job {
                Job::Reference(r) => self.references[r].slot.map(|(_, slot)| slot),
                _ => None,
            },
        });
        match job {
            Job::Reference(r) if !self.remote && outcome == Outcome::Failed => self.give_up(r, now),
            Job::Reference(r) => {
                self.references[r].rendered = Some(now);
                if !self.remote {
                    self.arrive(r, now);
                } else if self.references[r].lost.is_none() {
                    self.answer.push_back(r);
                }
            }
            Job::Target(frame) => {
                if outcome == Outcome::Failed {
                    self.frames[frame].refused = Some(now);
                    self.fallbacks.insert(frame);
                } else {
                    self.finish(frame, now, Made::Warped, waits);
                }
                self.read(self.window(frame), now);
            }
            Job::Fallback(frame) => {
                let made = match self.frames[frame].refused {
                    Some(_) => Made::FullByAngle,
                    None => Made::FullByLoss,
                };
                self.finish(frame, now, made, waits);
            }
            Job::Request(_) | Job::Answer(_) => {}
        }
    }

    /// The pose of a frame has arrived.
    pub(super) fn pose(&mut self, frame: usize, now: Nanos) {
        self.frames[frame].pose = Some(now);
        self.admit(frame, now);
    }

    /// A request has arrived at the server.
    pub(super) fn asked(&mut self, reference: usize, now: Nanos) {
        self.references[reference].asked = Some(now);
        if self.references[reference].lost.is_none() {
            self.serve.push_back(reference);
        }
    }

    /// A reference has arrived in its slot, unless it was given up before.
    pub(super) fn arrive(&mut self, reference: usize, now: Nanos) {
        if self.references[reference].lost.is_none() {
            self.references[reference].ready = Some(now);
            for frame in self.windows.of(reference) {
                self.admit(frame, now);
            }
        }
    }

    /// A reference is given up, unless it is there: what was not begun for it
    /// is not begun any more.
    pub(super) fn give_up(&mut self, reference: usize, now: Nanos) {
        if self.references[reference].ready.is_some() {
            return;
        }
        self.references[reference].lost = Some(now);
        self.serve.retain(|r| *r != reference);
        self.answer.retain(|r| *r != reference);
        self.buffer.release(reference, now);
        for frame in self.windows.of(reference) {
            self.admit(frame, now);
        }
    }

    /// Queues a frame if its pose and its reference are there, or the latter is
    /// lost.
    fn admit(&mut self, frame: usize, now: Nanos) {
        let r = self.window(frame);
        let Some(pose) = self.frames[frame].pose else {
            return;
        };
        let state = &self.references[r];
        if state.lost.is_some() {
            self.fallbacks.insert(frame);
        } else if state.ready.is_some() {
            if self.plan.references[r].target == Some(frame) {
                let gates = self.gates(Job::Target(frame));
                let waits = split(pose, &gates, now, Cause::Renderer);
                self.finish(frame, now, Made::Reference, waits);
                self.read(r, now);
            } else {
                self.targets.insert(frame);
            }
        }
    }

    /// One of its targets has read a reference.
    fn read(&mut self, reference: usize, now: Nanos) {
        let readers = &mut self.references[reference].readers;
        *readers -= 1;
        if *readers == 0 {
            self.buffer.release(reference, now);
        }
    }

    fn finish(&mut self, frame: usize, now: Nanos, made: Made, waits: super::Waits) {
        self.frames[frame].finished = Some((now, made));
        self.frames[frame].waits = waits;
    }

    /// Shows the next frame, if it is finished.
    pub(super) fn show(&mut self, now: Nanos) -> Option<usize> {
        let next = self.next_shown;
        self.frames.get(next)?.finished?;
        self.frames[next].shown = Some(now);
        self.next_shown += 1;
        Some(next)
    }

    /// Whether all frames were shown.
    pub(super) fn is_over(&self) -> bool {
        self.next_shown == self.frames.len()
    }

    /// The frame that is shown next.
    pub(super) fn next_shown(&self) -> usize {
        self.next_shown
    }

    /// What a resource is at.
    pub(super) fn running(&self, resource: Resource) -> Option<Job> {
        self.running[resource as usize].as_ref().map(|r| r.job)
    }

    /// The slot of a reference that was begun.
    pub(super) fn slot(&self, reference: usize) -> Option<usize> {
        self.references[reference].slot.map(|(_, slot)| slot)
    }

    pub(super) fn into_record(self) -> Record {
        Record {
            resources: self.resources(),
            tasks: self.tasks,
            frames: self.frames,
            buffer: self.buffer,
        }
    }
}
