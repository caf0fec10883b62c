//! Discrete-event scheduler.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use potamoi_warp::{Counts, Plan};

use super::clock::later;
use super::dispatch::Dispatcher;
use super::finish::finish;
use super::{
    Clock, Job, LinkUse, Nanos, Options, Poses, Remote, Resource, Schedule, ScheduleError,
};
use crate::frame_scheduler::Outcome;

/// Events, in the order in which simultaneous ones are handled: a reference that arrives exactly at
/// its timeout has arrived.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Event {
    /// A resource's job ends.
    End(Resource),
    /// A request reaches the server.
    Asked(usize),
    /// A reference arrives.
    Arrive(usize),
    /// A reference times out.
    GiveUp(usize),
    /// A pose arrives.
    Pose(usize),
}

struct Simulation<'a> {
    dispatcher: Dispatcher,
    counts: &'a [Counts],
    clock: &'a dyn Clock,
    poses: Poses,
    remote: Option<&'a Remote>,
    events: BinaryHeap<Reverse<(Nanos, Event)>>,
    link: LinkUse,
}

/// Schedules a plan. `counts` are the pixels of each frame as warping classified them: a frame with
/// `full` pixels falls back to full rendering, unless it is itself the reference. With `remote`, a
/// server renders references, and the local full renderer only fallbacks.
///
/// Events are handled in the order of their times, and simultaneous events in an order that depends
/// on the plan alone: the same arguments give the same schedule. Its size is proportional to the
/// plan's.
///
/// A faster resource never shows the last frame later in two cases: where one renderer does all, as
/// its work is the same in any order, and where no angle is too large, as two renderers then have
/// no choice. Elsewhere it can, as in any list scheduling (Graham, "Bounds on multiprocessing
/// timing anomalies", 1969): a job that is ready sooner may begin before a more urgent one that is
/// about to be ready, and nothing is interrupted. This concerns full fallbacks beside references,
/// and requests beside answers on the link.
///
/// # Errors
/// Options out of range, an inconsistent plan, counts of another number of frames, times beyond 64
/// bits.
pub fn schedule(
    plan: &Plan,
    counts: &[Counts],
    clock: &dyn Clock,
    options: &Options,
    remote: Option<&Remote>,
) -> Result<Schedule, ScheduleError> {
    if let Some(remote) = remote {
        remote.check()?;
    }
    if counts.len() != plan.targets.len() {
        return Err(ScheduleError::Length {
            what: "counts",
            found: counts.len(),
            expected: plan.targets.len(),
        });
    }
    let mut simulation = Simulation {
        dispatcher: Dispatcher::new(plan, options, remote.is_some())?,
        counts,
        clock,
        poses: options.poses,
        remote,
        events: BinaryHeap::new(),
        link: LinkUse::default(),
    };
    simulation.run()?;
    finish(simulation.dispatcher.into_record(), plan, simulation.link)
}

impl Simulation<'_> {
    fn run(&mut self) -> Result<(), ScheduleError> {
        let resources = self.dispatcher.resources();
        self.await_pose(0)?;
        while let Some(Reverse((now, event))) = self.events.pop() {
            self.handle(event, now)?;
            // Nothing is begun before all that happens at once has happened.
            while let Some(Reverse((time, event))) = self.events.peek().copied() {
                if time != now {
                    break;
                }
                self.events.pop();
                self.handle(event, now)?;
            }
            while let Some(frame) = self.dispatcher.show(now) {
                if self.poses == Poses::OnShown && frame + 1 < self.counts.len() {
                    self.events.push(Reverse((now, Event::Pose(frame + 1))));
                }
            }
            for resource in &resources {
                if let Some(job) = self.dispatcher.begin(*resource, now) {
                    self.begin(*resource, job, now)?;
                }
            }
        }
        Ok(())
    }

    /// Schedules the arrival of a frame's pose, if its time is known beforehand.
    fn await_pose(&mut self, frame: usize) -> Result<(), ScheduleError> {
        if frame < self.counts.len()
            && let Some(time) = self.poses.at(frame)?
        {
            self.events.push(Reverse((time, Event::Pose(frame))));
        }
        Ok(())
    }

    fn handle(&mut self, event: Event, now: Nanos) -> Result<(), ScheduleError> {
        match event {
            Event::End(resource) => {
                let job = self.dispatcher.running(resource);
                let refused = matches!(job, Some(Job::Target(k)) if self.counts[k].full > 0);
                let outcome = if refused {
                    Outcome::Failed
                } else {
                    Outcome::Right
                };
                self.dispatcher.end(resource, now, outcome);
            }
            Event::Asked(reference) => self.dispatcher.asked(reference, now),
            Event::Arrive(reference) => self.dispatcher.arrive(reference, now),
            Event::GiveUp(reference) => self.dispatcher.give_up(reference, now),
            Event::Pose(frame) => {
                self.dispatcher.pose(frame, now);
                self.await_pose(frame + 1)?;
            }
        }
        Ok(())
    }

    /// Computes the end of a job that has begun, and the events that follow from it.
    fn begin(&mut self, resource: Resource, job: Job, now: Nanos) -> Result<(), ScheduleError> {
        let duration = match (job, self.remote) {
            (Job::Reference(r), None) => self.clock.reference(r),
            (Job::Reference(r), Some(_)) => self.clock.served(r),
            (Job::Target(frame), _) => self.clock.target(frame, &self.counts[frame]),
            (Job::Fallback(frame), _) => self.clock.full(frame),
            (Job::Request(r) | Job::Answer(r), Some(remote)) => {
                return self.send(remote, job, r, now);
            }
            // Nothing is sent where there is no server.
            (Job::Request(_) | Job::Answer(_), None) => 0,
        };
        let end = later(now, duration, || format!("the end of {job:?}"))?;
        self.events.push(Reverse((end, Event::End(resource))));
        Ok(())
    }

    fn send(
        &mut self,
        remote: &Remote,
        job: Job,
        reference: usize,
        now: Nanos,
    ) -> Result<(), ScheduleError> {
        let request = matches!(job, Job::Request(_));
        let (bytes, arrives) = if request {
            (remote.request_bytes, Some(Event::Asked(reference)))
        } else {
            let lost = remote.lost.contains(&reference);
            (
                remote.reference_bytes,
                (!lost).then_some(Event::Arrive(reference)),
            )
        };
        let name = || format!("{job:?}");
        let end = later(now, remote.link.time(bytes, &name())?, || {
            format!("the end of {job:?}")
        })?;
        self.events.push(Reverse((end, Event::End(Resource::Link))));
        if let Some(event) = arrives {
            let time = later(end, remote.link.latency, || {
                format!("the arrival of {job:?}")
            })?;
            self.events.push(Reverse((time, event)));
        }
        if request {
            let over = later(now, remote.timeout, || format!("the timeout of {job:?}"))?;
            self.events.push(Reverse((over, Event::GiveUp(reference))));
        }
        let overflow = |what: &str, unit| ScheduleError::Overflow {
            what: what.to_owned(),
            unit,
        };
        let (sum, nanojoules) = (self.link.bytes, remote.link.nanojoules_per_byte);
        self.link.bytes = sum
            .checked_add(bytes)
            .ok_or_else(|| overflow("the traffic of the link", "bytes"))?;
        self.link.nanojoules = (self.link.bytes)
            .checked_mul(nanojoules)
            .ok_or_else(|| overflow("the energy of the link", "nJ"))?;
        Ok(())
    }
}
