//! Timestamps of known jobs, and limits that no schedule breaks.

#![allow(clippy::unwrap_used)]
use proptest::prelude::*;

use super::*;

fn job(resource: Resource, own_ns: f64, memory_ns: f64, after: &[JobId]) -> Job {
    Job {
        stage: "test",
        resource,
        own_ns,
        shares: vec![share(Shared::Memory, memory_ns)],
        after: after.to_vec(),
        rank: 0,
    }
}

const fn share(of: Shared, ns: f64) -> Share {
    Share { of, ns }
}

fn with(mut job: Job, of: Shared, ns: f64) -> Job {
    job.shares.push(share(of, ns));
    job
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

/// Two jobs that move 10 ns of bytes each at once take 20 ns; their own work overlaps.
#[test]
fn memory_is_shared_evenly() {
    use Resource::{Gpu, VectorUnit};
    let jobs = [job(Gpu, 12.0, 10.0, &[]), job(VectorUnit, 1.0, 10.0, &[])];
    let times = run(&jobs).unwrap();
    assert_eq!((times[0].end_ns, times[1].end_ns), (20.0, 20.0));
    assert_eq!((times[0].own_done_ns, times[1].own_done_ns), (12.0, 1.0));
    assert_eq!(times[0].through_ns, [20.0]);
    // A shorter one leaves the rest to the longer.
    let jobs = [job(Gpu, 0.0, 10.0, &[]), job(VectorUnit, 0.0, 4.0, &[])];
    let times = run(&jobs).unwrap();
    assert_eq!((times[1].end_ns, times[0].end_ns), (8.0, 14.0));
}

/// Bytes are done when the slower of both channels is; each channel is shared by itself.
#[test]
fn the_interconnect_is_shared_beside_memory() {
    use Resource::{Gpu, VectorUnit};
    let through = |job: Job, ns| with(job, Shared::Interconnect, ns);
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

/// Groups of banks are shared independently: two jobs in one group share its bandwidth, two in
/// different groups do not.
#[test]
fn banks_are_shared_by_group() {
    use Resource::{GatheringUnit, Npu};
    let in_group =
        |resource, group| with(job(resource, 5.0, 0.0, &[]), Shared::Features(group), 8.0);
    let times = run(&[in_group(GatheringUnit, 0), in_group(Npu, 0)]).unwrap();
    assert_eq!((times[0].end_ns, times[1].end_ns), (16.0, 16.0));
    let times = run(&[in_group(GatheringUnit, 0), in_group(Npu, 1)]).unwrap();
    assert_eq!((times[0].end_ns, times[1].end_ns), (8.0, 8.0));
    assert_eq!(
        (times[0].own_done_ns, &times[0].through_ns[..]),
        (5.0, &[0.0, 8.0][..])
    );
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
    assert!(order.to_string().contains("depends on job 0"), "{order}");
    for bad in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(run(&[job(Gpu, bad, 0.0, &[])]).is_err());
        assert!(run(&[job(Gpu, 0.0, bad, &[])]).is_err());
        let wired = with(job(Gpu, 0.0, 0.0, &[]), Shared::Weights, bad);
        assert!(run(&[wired]).is_err());
    }
}

const RESOURCES: [Resource; 4] = [
    Resource::Gpu,
    Resource::Npu,
    Resource::GatheringUnit,
    Resource::VectorUnit,
];

const SHARED: [Shared; 4] = [
    Shared::Memory,
    Shared::Interconnect,
    Shared::Features(0),
    Shared::Features(7),
];

fn any_jobs() -> impl Strategy<Value = Vec<Job>> {
    let one = (
        0usize..4,
        prop::array::uniform5(0u32..20),
        prop::collection::vec(any::<usize>(), 0..3),
    );
    prop::collection::vec(one, 1..30).prop_map(|all| {
        let jobs = all.into_iter().enumerate();
        jobs.map(|(id, (resource, [own, shares @ ..], after))| {
            let mut after: Vec<JobId> = match id {
                0 => vec![],
                _ => after.into_iter().map(|a| a % id).collect(),
            };
            after.sort_unstable();
            after.dedup();
            Job {
                shares: (SHARED.iter().zip(shares))
                    .map(|(of, ns)| share(*of, ns.into()))
                    .collect(),
                ..job(RESOURCES[resource], own.into(), 0.0, &after)
            }
        })
        .collect()
    })
}

proptest! {
    /// No resource, shared channel or chain of jobs is faster than its limit.
    #[test]
    fn no_limit_is_broken(jobs in any_jobs()) {
        let times = run(&jobs).unwrap();
        let end = times.iter().map(|t| t.end_ns).fold(0.0, f64::max);
        let near = 1.0 - 1e-9;
        for of in SHARED {
            prop_assert!(end >= near * jobs.iter().map(|j| j.alone_ns(of)).sum::<f64>());
        }
        let most = |j: &Job| j.shares.iter().map(|share| share.ns).fold(j.own_ns, f64::max);
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

    /// Some resource is always at work: the end is no later than that of all jobs in sequence.
    #[test]
    fn no_time_goes_by_idle(jobs in any_jobs()) {
        let all = jobs.iter().map(|j| j.own_ns + j.shares.iter().map(|share| share.ns).sum::<f64>());
        let all: f64 = all.sum();
        prop_assert!(end(&jobs) <= all + 1e-6);
    }

    /// A shared channel of twice the bandwidth never makes a chain slower.
    #[test]
    fn faster_shares_end_a_chain_no_later(jobs in any_jobs(), of in 0usize..4) {
        let chain = |factor: f64| -> Vec<Job> {
            let scaled = |own: &Share| match own.of == SHARED[of] {
                true => share(own.of, own.ns * factor),
                false => *own,
            };
            let chained = jobs.iter().enumerate().map(|(id, own)| Job {
                shares: own.shares.iter().map(scaled).collect(),
                after: id.checked_sub(1).into_iter().collect(),
                ..own.clone()
            });
            chained.collect()
        };
        prop_assert!(end(&chain(0.5)) <= end(&chain(1.0)) + 1e-9);
    }
}
