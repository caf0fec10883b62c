//! Jobs on resources: what runs when, and what it waits for.
//!
//! A resource does one job at a time. Memory and the interconnect are shared: jobs that move bytes at
//! the same time each get an equal part of both, and a job ends when its own work is done and its
//! bytes are through both.
//! Buffers are dependencies: what fills a buffer comes after what emptied it.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;
use thiserror::Error;

/// A job of the list, by its place.
pub type JobId = usize;

/// Something that does one job at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Resource {
    /// Indexing, sorting, warping, and gathering where no unit does it.
    Gpu,
    /// The systolic array.
    Npu,
    /// The gathering unit.
    GatheringUnit,
    /// The vector unit.
    VectorUnit,
    /// The wireless link.
    Link,
    /// A renderer at the other end of the link.
    Remote,
}

/// Work for a resource.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// What it is part of, as reports name it.
    pub stage: &'static str,
    /// Where it runs.
    pub resource: Resource,
    /// Nanoseconds that it takes by itself.
    pub own_ns: f64,
    /// Nanoseconds that memory needs for its bytes, were they alone.
    pub memory_ns: f64,
    /// Nanoseconds that the interconnect needs for them, were they alone.
    pub interconnect_ns: f64,
    /// Jobs that have to end before: of smaller places.
    pub after: Vec<JobId>,
    /// Of jobs that are ready for the same resource, that with the smallest number begins,
    /// then the one that stands first.
    pub rank: u64,
}

/// When a job was what.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Times {
    /// The last of what it comes after ended.
    pub ready_ns: f64,
    /// It began.
    pub begin_ns: f64,
    /// Its own work was done.
    pub own_done_ns: f64,
    /// Its bytes were through memory, and through the interconnect; 0 where it has none.
    pub through_ns: [f64; 2],
    /// It ended.
    pub end_ns: f64,
}

/// Jobs that cannot be run.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum EngineError {
    /// A job comes after one that does not stand before it.
    #[error("job {job} ({stage}) comes after job {after}, which does not stand before it")]
    Order {
        /// Its place.
        job: JobId,
        /// Its stage.
        stage: &'static str,
        /// What it names.
        after: JobId,
    },
    /// A time is negative or no number.
    #[error("job {job} ({stage}): {field} is {value} ns, expected a number from 0 on")]
    Time {
        /// Its place.
        job: JobId,
        /// Its stage.
        stage: &'static str,
        /// The field.
        field: &'static str,
        /// What it is.
        value: f64,
    },
}

/// A job that has begun.
#[derive(Debug)]
struct Running {
    job: JobId,
    own_ns: f64,
    /// Of memory and of the interconnect, were the job alone.
    shared_ns: [f64; 2],
}

impl Running {
    fn is_over(&self) -> bool {
        self.own_ns <= 0.0 && self.shared_ns.iter().all(|ns| *ns <= 0.0)
    }
}

/// Runs all jobs; the times of each.
///
/// # Errors
/// A job comes after one that does not stand before it, or a time is no time.
pub fn run(jobs: &[Job]) -> Result<Vec<Times>, EngineError> {
    check(jobs)?;
    let mut waiting: Vec<usize> = jobs.iter().map(|job| job.after.len()).collect();
    let mut followers = vec![vec![]; jobs.len()];
    for (id, job) in jobs.iter().enumerate() {
        for &before in &job.after {
            followers[before].push(id);
        }
    }
    let mut times = vec![Times::default(); jobs.len()];
    let mut ready: BTreeMap<Resource, BTreeSet<(u64, JobId)>> = BTreeMap::new();
    for (id, job) in jobs.iter().enumerate().filter(|(id, _)| waiting[*id] == 0) {
        ready
            .entry(job.resource)
            .or_default()
            .insert((job.rank, id));
    }
    let mut running: BTreeMap<Resource, Running> = BTreeMap::new();
    let mut now = 0.0;
    loop {
        for (resource, queue) in &mut ready {
            if running.contains_key(resource) {
                continue;
            }
            if let Some((_, id)) = queue.pop_first() {
                let job = &jobs[id];
                times[id].begin_ns = now;
                let begun = Running {
                    job: id,
                    own_ns: job.own_ns,
                    shared_ns: [job.memory_ns, job.interconnect_ns],
                };
                running.insert(*resource, begun);
            }
        }
        if running.is_empty() {
            return Ok(times);
        }
        now += advance(&mut running, now, &mut times);
        let over: Vec<Resource> = running
            .iter()
            .filter(|(_, own)| own.is_over())
            .map(|(resource, _)| *resource)
            .collect();
        for resource in over {
            let Some(own) = running.remove(&resource) else {
                continue;
            };
            times[own.job].end_ns = now;
            for &next in &followers[own.job] {
                waiting[next] -= 1;
                if waiting[next] == 0 {
                    let job = &jobs[next];
                    times[next].ready_ns = now;
                    ready
                        .entry(job.resource)
                        .or_default()
                        .insert((job.rank, next));
                }
            }
        }
    }
}

/// Goes on to the next time at which something is done; the nanoseconds until then.
fn advance(running: &mut BTreeMap<Resource, Running>, now: f64, times: &mut [Times]) -> f64 {
    let sharing = [0, 1].map(|of| {
        let moving = running.values().filter(|own| own.shared_ns[of] > 0.0);
        moving.count() as f64
    });
    let next = |own: &Running| {
        let [memory, interconnect] = [0, 1].map(|of| own.shared_ns[of] * sharing[of]);
        let left = [own.own_ns, memory, interconnect].into_iter();
        let first = left.filter(|ns| *ns > 0.0).fold(f64::INFINITY, f64::min);
        if first.is_finite() { first } else { 0.0 }
    };
    let step = running.values().map(next).fold(f64::INFINITY, f64::min);
    for own in running.values_mut() {
        // What is done is done exactly: no rest of a rounding error stays.
        if own.own_ns > 0.0 {
            own.own_ns = if own.own_ns <= step {
                0.0
            } else {
                own.own_ns - step
            };
            if own.own_ns <= 0.0 {
                times[own.job].own_done_ns = now + step;
            }
        } else if times[own.job].own_done_ns < times[own.job].begin_ns {
            times[own.job].own_done_ns = times[own.job].begin_ns;
        }
        let through = &mut times[own.job].through_ns;
        for ((left, sharing), through) in own.shared_ns.iter_mut().zip(sharing).zip(through) {
            let done = *left * sharing <= step;
            if done && *left > 0.0 {
                *through = now + step;
            }
            *left = if done { 0.0 } else { *left - step / sharing };
        }
    }
    step
}

fn check(jobs: &[Job]) -> Result<(), EngineError> {
    for (id, job) in jobs.iter().enumerate() {
        let stage = job.stage;
        if let Some(&after) = job.after.iter().find(|before| **before >= id) {
            return Err(EngineError::Order {
                job: id,
                stage,
                after,
            });
        }
        for (field, value) in [
            ("own_ns", job.own_ns),
            ("memory_ns", job.memory_ns),
            ("interconnect_ns", job.interconnect_ns),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(EngineError::Time {
                    job: id,
                    stage,
                    field,
                    value,
                });
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;

    fn job(resource: Resource, own_ns: f64, memory_ns: f64, after: &[JobId]) -> Job {
        Job {
            stage: "test",
            resource,
            own_ns,
            memory_ns,
            interconnect_ns: 0.0,
            after: after.to_vec(),
            rank: 0,
        }
    }

    fn end(jobs: &[Job]) -> f64 {
        let times = run(jobs).unwrap();
        times.iter().map(|t| t.end_ns).fold(0.0, f64::max)
    }

    #[test]
    fn a_resource_does_one_job_at_a_time_and_others_go_on() {
        use Resource::{Gpu, Npu};
        let jobs = [
            job(Gpu, 10.0, 0.0, &[]),
            job(Gpu, 10.0, 0.0, &[]),
            job(Npu, 5.0, 0.0, &[0]),
        ];
        let times = run(&jobs).unwrap();
        assert_eq!(
            (times[1].ready_ns, times[1].begin_ns, times[1].end_ns),
            (0.0, 10.0, 20.0)
        );
        assert_eq!((times[2].begin_ns, times[2].end_ns), (10.0, 15.0));
    }

    /// Two that move 10 ns of bytes each at the same time take 20; own work goes on beside.
    #[test]
    fn memory_is_shared_evenly() {
        use Resource::{Gpu, VectorUnit};
        let jobs = [job(Gpu, 12.0, 10.0, &[]), job(VectorUnit, 1.0, 10.0, &[])];
        let times = run(&jobs).unwrap();
        assert_eq!((times[0].end_ns, times[1].end_ns), (20.0, 20.0));
        assert_eq!((times[0].own_done_ns, times[1].own_done_ns), (12.0, 1.0));
        assert_eq!(times[0].through_ns, [20.0, 0.0]);
        // A shorter one leaves the rest to the longer.
        let jobs = [job(Gpu, 0.0, 10.0, &[]), job(VectorUnit, 0.0, 4.0, &[])];
        let times = run(&jobs).unwrap();
        assert_eq!((times[1].end_ns, times[0].end_ns), (8.0, 14.0));
    }

    /// Bytes are through when they are through the slower of both; each is shared by itself.
    #[test]
    fn the_interconnect_is_shared_beside_memory() {
        use Resource::{Gpu, VectorUnit};
        let through = |mut job: Job, ns| {
            job.interconnect_ns = ns;
            job
        };
        let slow = [through(job(Gpu, 1.0, 4.0, &[]), 9.0)];
        assert_eq!(end(&slow), 9.0);
        let jobs = [
            through(job(Gpu, 0.0, 10.0, &[]), 4.0),
            through(job(VectorUnit, 0.0, 2.0, &[]), 12.0),
        ];
        let times = run(&jobs).unwrap();
        // Memory: 2 each until 4, then 8 of one; the interconnect: 4 each until 8, then 8 of the other.
        assert_eq!((times[0].end_ns, times[1].end_ns), (12.0, 16.0));
        assert_eq!(times[0].through_ns, [12.0, 8.0]);
        assert_eq!(times[1].through_ns, [4.0, 16.0]);
    }

    /// Loads into two halves of a buffer: the third waits until the first was used.
    #[test]
    fn two_halves_hide_what_is_loaded_behind_what_is_used() {
        use Resource::{GatheringUnit, VectorUnit};
        let chain = |halves: usize| {
            let mut jobs: Vec<Job> = vec![];
            let mut used = vec![];
            for i in 0..10 {
                let mut after = vec![];
                if i >= halves {
                    after.push(used[i - halves]);
                }
                jobs.push(job(VectorUnit, 0.0, 6.0, &after));
                let load = jobs.len() - 1;
                jobs.push(job(GatheringUnit, 10.0, 0.0, &[load]));
                used.push(jobs.len() - 1);
            }
            end(&jobs)
        };
        assert_eq!(chain(1), 160.0);
        assert_eq!(chain(2), 106.0);
    }

    #[test]
    fn what_cannot_be_run_is_refused() {
        use Resource::Gpu;
        let order = run(&[job(Gpu, 1.0, 0.0, &[0])]).unwrap_err();
        assert!(order.to_string().contains("comes after job 0"), "{order}");
        for bad in [-1.0, f64::NAN, f64::INFINITY] {
            assert!(run(&[job(Gpu, bad, 0.0, &[])]).is_err());
            assert!(run(&[job(Gpu, 0.0, bad, &[])]).is_err());
            let mut wired = job(Gpu, 0.0, 0.0, &[]);
            wired.interconnect_ns = bad;
            assert!(run(&[wired]).is_err());
        }
    }

    const RESOURCES: [Resource; 4] = [
        Resource::Gpu,
        Resource::Npu,
        Resource::GatheringUnit,
        Resource::VectorUnit,
    ];

    fn any_jobs() -> impl Strategy<Value = Vec<Job>> {
        let one = (
            0usize..4,
            [0u32..20, 0u32..20, 0u32..20],
            prop::collection::vec(any::<usize>(), 0..3),
        );
        prop::collection::vec(one, 1..30).prop_map(|all| {
            let jobs = all.into_iter().enumerate();
            jobs.map(|(id, (resource, [own, memory, interconnect], after))| {
                let mut after: Vec<JobId> = match id {
                    0 => vec![],
                    _ => after.into_iter().map(|a| a % id).collect(),
                };
                after.sort_unstable();
                after.dedup();
                Job {
                    interconnect_ns: interconnect.into(),
                    ..job(RESOURCES[resource], own.into(), memory.into(), &after)
                }
            })
            .collect()
        })
    }

    proptest! {
        /// Nothing is faster than a resource, than memory, or than a chain of jobs allows.
        #[test]
        fn no_limit_is_broken(jobs in any_jobs()) {
            let times = run(&jobs).unwrap();
            let end = times.iter().map(|t| t.end_ns).fold(0.0, f64::max);
            let near = 1.0 - 1e-9;
            prop_assert!(end >= near * jobs.iter().map(|j| j.memory_ns).sum::<f64>());
            prop_assert!(end >= near * jobs.iter().map(|j| j.interconnect_ns).sum::<f64>());
            let most = |j: &Job| j.own_ns.max(j.memory_ns).max(j.interconnect_ns);
            for resource in RESOURCES {
                let own = jobs.iter().filter(|j| j.resource == resource);
                prop_assert!(end >= near * own.map(most).sum::<f64>());
            }
            for (job, at) in jobs.iter().zip(&times) {
                prop_assert!(at.end_ns - at.begin_ns >= near * most(job) - 1e-9);
                prop_assert!(at.ready_ns <= at.begin_ns && at.begin_ns <= at.own_done_ns);
                prop_assert!(at.own_done_ns <= at.end_ns + 1e-9);
                for before in &job.after {
                    prop_assert!(times[*before].end_ns <= at.begin_ns);
                }
            }
        }

        /// Something is always under way: the end is no later than all work one after the other.
        #[test]
        fn no_time_goes_by_idle(jobs in any_jobs()) {
            let all = jobs.iter().map(|j| j.own_ns + j.memory_ns + j.interconnect_ns);
            let all: f64 = all.sum();
            prop_assert!(end(&jobs) <= all + 1e-6);
        }

        /// Memory that is twice as fast never makes a chain slower.
        #[test]
        fn faster_memory_ends_a_chain_no_later(jobs in any_jobs()) {
            let chain = |factor: f64| -> Vec<Job> {
                let chained = jobs.iter().enumerate().map(|(id, own)| Job {
                    memory_ns: own.memory_ns * factor,
                    after: id.checked_sub(1).into_iter().collect(),
                    ..own.clone()
                });
                chained.collect()
            };
            prop_assert!(end(&chain(0.5)) <= end(&chain(1.0)) + 1e-9);
        }
    }
}
