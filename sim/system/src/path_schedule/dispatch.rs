//! Dispatcher: assigns ready jobs to renderers, and records what they waited for.

use potamoi_warp::Plan;

use super::finish::DispatchRecord;
use super::waits::split;
use super::windows;
use super::{Job, Nanos, Options, Resource, ScheduleError, Task, Waits};
use crate::frame_scheduler::{Cause, FrameScheduler, Outcome, Reference};

#[derive(Debug, Clone)]
struct Running {
    job: Job,
    start: Nanos,
    gates: Vec<(Cause, Nanos)>,
    free_since: Nanos,
}

/// Renderers, a server and a link, one job at a time each, on jobs that the [`FrameScheduler`]
/// reports as ready. It has no clock: times are only recorded, and must be told in order.
#[derive(Debug)]
pub(super) struct Dispatcher {
    frames: FrameScheduler<Nanos>,
    concurrent: bool,
    remote: bool,
    /// Waits of each frame.
    waits: Vec<Waits>,
    running: [Option<Running>; Resource::ALL.len()],
    free_since: [Nanos; Resource::ALL.len()],
    tasks: Vec<Task>,
}

impl Dispatcher {
    pub(super) fn new(plan: &Plan, options: &Options, remote: bool) -> Result<Self, ScheduleError> {
        options.check()?;
        let windows = windows::checked(plan, options.poses)?;
        let references = plan.references.iter().map(|task| Reference {
            known: task.known,
            shown_as: task.target,
        });
        Ok(Self {
            frames: FrameScheduler::new(windows, references.collect(), options.slots, remote),
            concurrent: options.concurrent,
            remote,
            waits: vec![Waits::default(); plan.targets.len()],
            running: [const { None }; Resource::ALL.len()],
            free_since: [0; Resource::ALL.len()],
            tasks: vec![],
        })
    }

    /// Resources of this system.
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

    /// Begins the most urgent ready job of a resource, if the resource is free.
    pub(super) fn begin(&mut self, resource: Resource, now: Nanos) -> Option<Job> {
        if self.running[resource as usize].is_some() {
            return None;
        }
        let jobs = self.frames.ready();
        let job = jobs
            .filter(|job| self.resource(*job) == resource)
            .min_by_key(|job| self.frames.urgency(*job))?;
        self.frames.begin(job, now);
        self.running[resource as usize] = Some(Running {
            job,
            start: now,
            gates: self.frames.awaited(job),
            free_since: self.free_since[resource as usize],
        });
        Some(job)
    }

    /// Records that a resource's job has ended.
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
                Job::Reference(r) => self.frames.slot(r),
                _ => None,
            },
        });
        let finished = self.frames.end(job, now, outcome);
        match job {
            Job::Target(frame) | Job::Fallback(frame) => self.waits[frame] = waits,
            _ => self.finished_as_reference(finished, now),
        }
    }

    /// Records the wait of a frame that is its own reference.
    fn finished_as_reference(&mut self, frame: Option<usize>, now: Nanos) {
        if let Some(frame) = frame
            && let Some(pose) = self.frames.frame(frame).pose
        {
            let gates = self.frames.awaited(Job::Target(frame));
            self.waits[frame] = split(pose, &gates, now, Cause::Renderer);
        }
    }

    /// Records that the pose of a frame has arrived.
    pub(super) fn pose(&mut self, frame: usize, now: Nanos) {
        let finished = self.frames.pose(frame, now);
        self.finished_as_reference(finished, now);
    }

    /// Records that a request has arrived at the server.
    pub(super) fn asked(&mut self, reference: usize, now: Nanos) {
        self.frames.asked(reference, now);
    }

    /// Records that a reference has arrived in its slot, unless it was given up before.
    pub(super) fn arrive(&mut self, reference: usize, now: Nanos) {
        let finished = self.frames.arrive(reference, now);
        self.finished_as_reference(finished, now);
    }

    /// Gives up a reference, unless it has arrived.
    pub(super) fn give_up(&mut self, reference: usize, now: Nanos) {
        self.frames.give_up(reference, now);
    }

    /// Shows the next frame, if it is finished.
    pub(super) fn show(&mut self, now: Nanos) -> Option<usize> {
        self.frames.show(now)
    }

    /// Whether all frames have been shown.
    pub(super) fn is_over(&self) -> bool {
        self.frames.is_over()
    }

    /// The next frame to show.
    pub(super) fn next_shown(&self) -> usize {
        self.frames.next_shown()
    }

    /// The job that a resource is running.
    pub(super) fn running(&self, resource: Resource) -> Option<Job> {
        self.running[resource as usize].as_ref().map(|r| r.job)
    }

    /// The slot of a reference that has begun.
    pub(super) fn slot(&self, reference: usize) -> Option<usize> {
        self.frames.slot(reference)
    }

    pub(super) fn into_record(self) -> DispatchRecord {
        let resources = self.resources();
        let (frames, holds) = self.frames.into_parts();
        DispatchRecord {
            resources,
            tasks: self.tasks,
            frames,
            waits: self.waits,
            holds,
        }
    }
}
