//! Job scheduler: start and end of jobs with dependencies on resources.
//!
//! A resource does one job at a time. Memory, the interconnect and the ports of buffers are shared:
//! jobs that move bytes through one of them at the same time get equal parts of its bandwidth. A
//! job ends when its own work is done and its bytes are through all of them. Room in buffers is a
//! dependency: a job that fills a buffer comes after the job that emptied it.

use std::collections::{BTreeMap, BTreeSet};

use schemars::JsonSchema;
use serde::Serialize;
use thiserror::Error;

/// Index of a job in the list.
pub type JobId = usize;

/// A resource, which does one job at a time.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Resource {
    /// GPU: indexing, sorting, warping, and gathering where no unit does it.
    Gpu,
    /// Systolic array.
    Npu,
    /// The gathering unit.
    GatheringUnit,
    /// The vector unit.
    VectorUnit,
    /// The splat units, all of them together.
    SplatUnits,
    /// The wireless link.
    Link,
    /// A renderer at the other end of the link.
    Remote,
}

impl Resource {
    /// Name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gpu => "GPU",
            Self::Npu => "MAC array",
            Self::GatheringUnit => "gathering unit",
            Self::VectorUnit => "vector unit",
            Self::SplatUnits => "splat units",
            Self::Link => "link",
            Self::Remote => "remote GPU",
        }
    }

    /// Whether it is a unit of the accelerator.
    #[must_use]
    pub const fn is_unit(self) -> bool {
        matches!(
            self,
            Self::Npu | Self::GatheringUnit | Self::VectorUnit | Self::SplatUnits
        )
    }
}

/// A shared channel: jobs that move bytes at the same time share its bandwidth.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Shared {
    /// Memory.
    Memory,
    /// Interconnect of memory, GPU and accelerator.
    Interconnect,
    /// Ports of a group of banks of the global feature buffer, by index.
    Features(u32),
    /// Port of the weight buffer.
    Weights,
}

impl Shared {
    /// Name in reports.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Memory => "memory",
            Self::Interconnect => "interconnect",
            Self::Features(_) => "feature buffer",
            Self::Weights => "weight buffer",
        }
    }
}

/// A job's demand on a shared channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Share {
    /// The channel.
    pub of: Shared,
    /// Nanoseconds that its bytes need at full bandwidth.
    pub ns: f64,
}

/// Work for a resource.
#[derive(Debug, Clone, PartialEq)]
pub struct Job {
    /// Stage that it belongs to, as in reports.
    pub stage: &'static str,
    /// Its resource.
    pub resource: Resource,
    /// Nanoseconds of its own work, without its bytes.
    pub own_ns: f64,
    /// Its demands, at most one per channel.
    pub shares: Vec<Share>,
    /// Dependencies, all earlier in the list.
    pub after: Vec<JobId>,
    /// Priority: of several jobs ready for a resource, the smallest rank begins first, then the
    /// smallest index.
    pub rank: u64,
}

impl Job {
    /// The job, without time where a unit of the accelerator does it. Its bytes of memory still
    /// move.
    pub(crate) fn with_free_units(&self) -> Self {
        let mut own = self.clone();
        if own.resource.is_unit() {
            own.own_ns = 0.0;
            own.shares
                .retain(|share| matches!(share.of, Shared::Memory | Shared::Interconnect));
        }
        own
    }

    /// Nanoseconds that its bytes need on a channel at full bandwidth.
    #[must_use]
    pub(crate) fn alone_ns(&self, of: Shared) -> f64 {
        let own = self.shares.iter().filter(|share| share.of == of);
        own.map(|share| share.ns).sum()
    }
}

/// Timestamps of a job in nanoseconds: ready, begin, own work done, transfers done, end.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct Times {
    /// Its last dependency ended.
    pub ready_ns: f64,
    /// Begin.
    pub begin_ns: f64,
    /// Its own work ended.
    pub own_done_ns: f64,
    /// Its transfers ended, in the order of its shares; 0 for a share of no bytes.
    pub through_ns: Vec<f64>,
    /// End.
    pub end_ns: f64,
}

/// Why jobs cannot be run.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum JobError {
    /// A job depends on one that is not before it in the list.
    #[error("job {job} ({stage}) depends on job {after}: expected a job before it in the list")]
    Order {
        /// Index of the job.
        job: JobId,
        /// Its stage.
        stage: &'static str,
        /// Index of the dependency.
        after: JobId,
    },
    /// A time is negative or not a number.
    #[error("job {job} ({stage}): {field} is {value} ns: expected a number of 0 or more")]
    Time {
        /// Index of the job.
        job: JobId,
        /// Its stage.
        stage: &'static str,
        /// Name of the field.
        field: &'static str,
        /// Its value.
        value: f64,
    },
}

/// A job that has begun.
#[derive(Debug)]
struct Running {
    job: JobId,
    own_ns: f64,
    /// Remaining nanoseconds of each share at full bandwidth.
    shares: Vec<Share>,
}

impl Running {
    fn is_over(&self) -> bool {
        self.own_ns <= 0.0 && self.shares.iter().all(|share| share.ns <= 0.0)
    }
}

/// Number of jobs that move bytes through each shared channel.
struct Moving(Vec<(Shared, f64)>);

impl Moving {
    fn of(running: &BTreeMap<Resource, Running>) -> Self {
        let mut all: Vec<(Shared, f64)> = vec![];
        let shares = running.values().flat_map(|own| &own.shares);
        for share in shares.filter(|share| share.ns > 0.0) {
            match all.iter_mut().find(|(of, _)| *of == share.of) {
                Some((_, jobs)) => *jobs += 1.0,
                None => all.push((share.of, 1.0)),
            }
        }
        Self(all)
    }

    /// Jobs that move bytes through a channel.
    fn through(&self, of: Shared) -> f64 {
        let own = self.0.iter().find(|own| own.0 == of);
        own.map_or(1.0, |(_, jobs)| *jobs)
    }
}

/// Runs all jobs. Returns the timestamps of each, in the order of the list.
///
/// # Errors
/// A job that depends on one not before it, or a time that is negative or not a number.
pub fn run(jobs: &[Job]) -> Result<Vec<Times>, JobError> {
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
                times[id].through_ns = vec![0.0; job.shares.len()];
                let begun = Running {
                    job: id,
                    own_ns: job.own_ns,
                    shares: job.shares.clone(),
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

/// Advances to the next completion. Returns the nanoseconds until then.
fn advance(running: &mut BTreeMap<Resource, Running>, now: f64, times: &mut [Times]) -> f64 {
    let moving = Moving::of(running);
    let next = |own: &Running| {
        let shared = own.shares.iter().map(|s| s.ns * moving.through(s.of));
        let left = std::iter::once(own.own_ns).chain(shared);
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
        for (share, through) in own.shares.iter_mut().zip(through) {
            let sharing = moving.through(share.of);
            let done = share.ns * sharing <= step;
            if done && share.ns > 0.0 {
                *through = now + step;
            }
            share.ns = if done { 0.0 } else { share.ns - step / sharing };
        }
    }
    step
}

fn check(jobs: &[Job]) -> Result<(), JobError> {
    for (id, job) in jobs.iter().enumerate() {
        let stage = job.stage;
        if let Some(&after) = job.after.iter().find(|before| **before >= id) {
            return Err(JobError::Order {
                job: id,
                stage,
                after,
            });
        }
        let shares = job.shares.iter().map(|share| ("a share", share.ns));
        for (field, value) in shares.chain([("own_ns", job.own_ns)]) {
            if !(value.is_finite() && value >= 0.0) {
                return Err(JobError::Time {
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
mod tests;
