//! Live execution: references and targets rendered on threads of their own.

use std::collections::BTreeMap;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use potamoi_base::camera::Camera;
use potamoi_warp::{Class, Frame, Plan, Shaded, Target, WarpError, Warper};

use super::dispatch::Dispatcher;
use super::finish::finish;
use super::{Job, LinkUse, Nanos, Options, Poses, Resource, Schedule, ScheduleError};
use crate::frame_scheduler::Outcome;

/// Finished frames that may wait to be shown; at more, rendering pauses.
pub(super) const AHEAD: usize = 4;

/// Source of references: rendered locally, as by a [`Warper`], or elsewhere.
pub trait References: Sync {
    /// A reference of a plan; `None` where it was lost.
    ///
    /// # Errors
    /// Those of the renderer.
    fn reference(&self, number: usize, camera: &Camera) -> Result<Option<Shaded>, WarpError>;
}

impl References for Warper<'_> {
    fn reference(&self, _: usize, camera: &Camera) -> Result<Option<Shaded>, WarpError> {
        self.reference(camera).map(Some)
    }
}

struct State {
    dispatcher: Dispatcher,
    /// The reference buffer.
    slots: Vec<Option<Arc<Shaded>>>,
    /// Frames not yet shown.
    finished: BTreeMap<usize, Frame>,
    error: Option<ScheduleError>,
    stopped: bool,
}

struct Live<'a> {
    warper: Warper<'a>,
    references: &'a dyn References,
    path: &'a [Camera],
    plan: &'a Plan,
    begun: Instant,
    state: Mutex<State>,
    changed: Condvar,
}

/// Stops all threads when one panics, so that none waits for ever.
struct StopOnPanic<'l, 'a>(&'l Live<'a>);

impl Drop for StopOnPanic<'_, '_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.lock().stopped = true;
            self.0.changed.notify_all();
        }
    }
}

/// Renders a path by its plan: references on one thread and targets on another (one thread for
/// both, without `concurrent`). The calling thread shows the frames in order and delivers the poses
/// at their times. Jobs begin by the rules of [`schedule`](super::schedule). The frames equal those
/// of [`Sequence`](potamoi_warp::Sequence), bit for bit, whatever the timing. Rendering pauses
/// while `show` lags behind, so that few frames are kept.
///
/// The times of the schedule are measured; its resources are the threads.
///
/// # Errors
/// Options out of range, a plan that is inconsistent or of another path, and the first error of a
/// renderer, after which nothing more is begun.
pub fn live(
    warper: Warper<'_>,
    references: &dyn References,
    path: &[Camera],
    plan: &Plan,
    options: &Options,
    show: impl FnMut(Frame),
) -> Result<Schedule, ScheduleError> {
    if path.len() != plan.targets.len() {
        return Err(ScheduleError::Length {
            what: "path",
            found: path.len(),
            expected: plan.targets.len(),
        });
    }
    let dispatcher = Dispatcher::new(plan, options, false)?;
    let workers = dispatcher.resources();
    let live = Live {
        warper,
        references,
        path,
        plan,
        begun: Instant::now(),
        state: Mutex::new(State {
            dispatcher,
            slots: vec![],
            finished: BTreeMap::new(),
            error: None,
            stopped: false,
        }),
        changed: Condvar::new(),
    };
    std::thread::scope(|scope| {
        let _guard = StopOnPanic(&live);
        for resource in workers {
            let live = &live;
            scope.spawn(move || {
                let _guard = StopOnPanic(live);
                live.work(resource);
            });
        }
        live.display(options.poses, show);
    });
    let state = live
        .state
        .into_inner()
        .unwrap_or_else(PoisonError::into_inner);
    match state.error {
        Some(error) => Err(error),
        None => finish(state.dispatcher.into_record(), plan, LinkUse::default()),
    }
}

impl Live<'_> {
    /// Locks the state. A thread that panicked under the lock has stopped the others.
    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn wait<'g>(&self, state: MutexGuard<'g, State>) -> MutexGuard<'g, State> {
        self.changed
            .wait(state)
            .unwrap_or_else(PoisonError::into_inner)
    }

    fn now(&self) -> Nanos {
        self.begun.elapsed().as_nanos() as Nanos
    }

    /// Delivers poses and shows frames, until all are shown.
    fn display(&self, poses: Poses, mut show: impl FnMut(Frame)) {
        let mut next_pose = 0;
        let mut state = self.lock();
        while !state.stopped {
            let now = self.now();
            let mut due = None;
            while next_pose < self.path.len() {
                let time = match poses.at(next_pose) {
                    Ok(Some(time)) => time,
                    Ok(None) if next_pose <= state.dispatcher.next_shown() => now,
                    Ok(None) => break,
                    Err(error) => {
                        state.error.get_or_insert(error);
                        break;
                    }
                };
                if time > now {
                    due = Some(Duration::from_nanos(time - now));
                    break;
                }
                state.dispatcher.pose(next_pose, now);
                next_pose += 1;
                self.changed.notify_all();
            }
            if state.error.is_some() || state.dispatcher.is_over() {
                state.stopped = true;
                break;
            }
            if let Some(number) = state.dispatcher.show(now) {
                let frame = state.finished.remove(&number);
                self.changed.notify_all();
                drop(state);
                frame.into_iter().for_each(&mut show);
                state = self.lock();
                continue;
            }
            state = match due {
                None => self.wait(state),
                Some(time) => {
                    let waited = self.changed.wait_timeout(state, time);
                    waited.unwrap_or_else(PoisonError::into_inner).0
                }
            };
        }
        drop(state);
        self.changed.notify_all();
    }

    /// Runs the jobs of a resource until all frames are shown or one fails.
    fn work(&self, resource: Resource) {
        loop {
            let mut state = self.lock();
            let job = loop {
                if state.stopped || state.error.is_some() {
                    return;
                }
                let next = state.dispatcher.next_shown();
                let behind = state.finished.len() >= AHEAD && state.finished.contains_key(&next);
                if !behind && let Some(job) = state.dispatcher.begin(resource, self.now()) {
                    break job;
                }
                state = self.wait(state);
            };
            if let Err(error) = self.render(state, resource, job) {
                self.lock().error.get_or_insert(error.into());
            }
            self.changed.notify_all();
        }
    }

    fn render(
        &self,
        mut state: MutexGuard<'_, State>,
        resource: Resource,
        job: Job,
    ) -> Result<(), WarpError> {
        match job {
            // Nothing is asked for over a link.
            Job::Request(_) | Job::Answer(_) => Ok(()),
            Job::Reference(number) => {
                let slot = state.dispatcher.slot(number).unwrap_or(0);
                if state.slots.len() <= slot {
                    state.slots.resize(slot + 1, None);
                }
                state.slots[slot] = None;
                drop(state);
                let task = &self.plan.references[number];
                let reference = self
                    .references
                    .reference(number, &task.camera)?
                    .map(Arc::new);
                let frame = match (&reference, task.target) {
                    (Some(reference), Some(shown)) => Some(Frame {
                        number: shown,
                        reference: None,
                        target: Target {
                            shaded: Shaded::clone(reference),
                            classes: vec![Class::Full; reference.depth.len()],
                        },
                    }),
                    _ => None,
                };
                let outcome = match reference {
                    Some(_) => Outcome::Right,
                    None => Outcome::Failed,
                };
                let mut state = self.lock();
                state.slots[slot] = reference;
                self.end(&mut state, resource, outcome, frame);
                Ok(())
            }
            Job::Target(number) => {
                let from = self.plan.targets[number].reference;
                let slot = state.dispatcher.slot(from);
                let reference = slot.and_then(|slot| state.slots.get(slot)?.clone());
                drop(state);
                let target = match reference {
                    Some(reference) => self.warper.sparse_target(
                        &reference,
                        &self.plan.references[from].camera,
                        &self.path[number],
                    )?,
                    None => None,
                };
                let frame = target.map(|target| Frame {
                    number,
                    reference: Some(from),
                    target,
                });
                let outcome = match frame {
                    Some(_) => Outcome::Right,
                    None => Outcome::Failed,
                };
                self.end(&mut self.lock(), resource, outcome, frame);
                Ok(())
            }
            Job::Fallback(number) => {
                drop(state);
                let frame = Frame {
                    number,
                    reference: Some(self.plan.targets[number].reference),
                    target: self.warper.full(&self.path[number])?,
                };
                self.end(&mut self.lock(), resource, Outcome::Right, Some(frame));
                Ok(())
            }
        }
    }

    fn end(&self, state: &mut State, resource: Resource, outcome: Outcome, frame: Option<Frame>) {
        state.dispatcher.end(resource, self.now(), outcome);
        if let Some(frame) = frame {
            state.finished.insert(frame.number, frame);
        }
    }
}
