//! Slots are held until their last reader, and both executors keep the same rules.

#![allow(clippy::unwrap_used)]

use glam::DVec3;
use potamoi_base::camera::Camera;
use potamoi_warp::{Counts, Plan, ReferenceTask, TargetTask};
use proptest::prelude::*;

use super::*;
use crate::path_schedule::{self, FixedClock, Options, Poses};
use crate::system_model::job_scheduler::{self, Resource};

fn scheduler<M: Copy + Default + Ord>(
    window: usize,
    known: &[usize],
    frames: usize,
    slots: usize,
) -> FrameScheduler<M> {
    let windows = Windows::every(window, known.len(), frames);
    let plan = known.iter().map(|known| Reference {
        known: *known,
        shown_as: None,
    });
    FrameScheduler::new(windows, plan.collect(), slots, false)
}

/// A job and its dependencies.
type Listed = (Job, Vec<usize>);

/// Jobs in the order in which they are listed, and the frame that is never rendered.
fn listed(frames: FrameScheduler<Option<usize>>) -> (Vec<Listed>, Option<(usize, usize)>) {
    let mut jobs = vec![];
    let left = unroll(frames, |job, after, _| {
        jobs.push((job, after.to_vec()));
        jobs.len() - 1
    });
    (jobs, left)
}

#[test]
fn a_slot_is_free_when_the_last_frame_of_its_window_is_made() {
    use Job::{Reference as R, Target as T};
    // All poses of references are known with the first frame's, and there are two slots.
    let (jobs, left) = listed(scheduler(2, &[0, 0, 0], 6, 2));
    let expected = [
        (R(0), vec![]),
        (R(1), vec![]),
        (T(0), vec![0]),
        (T(1), vec![2, 0]),
        // The third reference is listed as soon as its slot is free, not when its pose is known.
        (R(2), vec![3]),
        (T(2), vec![3, 1]),
        (T(3), vec![5, 1]),
        (T(4), vec![6, 4]),
        (T(5), vec![7, 4]),
    ];
    assert_eq!((&jobs[..], left), (&expected[..], None));
}

#[test]
fn a_reference_that_is_known_too_late_is_told() {
    let (_, left) = listed(scheduler(2, &[0, 3], 4, 2));
    assert_eq!(left, Some((2, 1)));
}

/// End times from both executors: from events in nanoseconds, and from dependencies of jobs.
fn ends(
    window: usize,
    known: &[usize],
    frames: usize,
    slots: usize,
    [reference, target]: [u64; 2],
) -> [Vec<(Job, u64, u64)>; 2] {
    let camera = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 0.9, 8, 6);
    let plan = Plan {
        references: (known.iter())
            .map(|known| ReferenceTask {
                camera,
                target: None,
                known: *known,
                predicted_for: None,
            })
            .collect(),
        targets: (0..frames)
            .map(|frame| TargetTask {
                reference: (frame / window).min(known.len() - 1),
            })
            .collect(),
    };
    let clock = FixedClock {
        reference,
        served: 0,
        target,
        full: 0,
    };
    let options = Options {
        poses: Poses::OnShown,
        slots,
        concurrent: true,
    };
    let counts = vec![Counts::default(); frames];
    let schedule = path_schedule::schedule(&plan, &counts, &clock, &options, None).unwrap();
    let mut timed: Vec<_> = schedule
        .tasks
        .iter()
        .map(|t| (t.job, t.start, t.end))
        .collect();
    timed.sort_unstable();

    let (mut names, mut jobs) = (vec![], vec![]);
    let left = unroll(
        scheduler(window, known, frames, slots),
        |job, after, rank| {
            let (resource, own_ns) = match job {
                Job::Reference(_) => (Resource::Remote, reference as f64),
                _ => (Resource::Gpu, target as f64),
            };
            names.push(job);
            jobs.push(job_scheduler::Job {
                stage: "frame",
                resource,
                own_ns,
                shares: vec![],
                after: after.to_vec(),
                rank,
            });
            jobs.len() - 1
        },
    );
    assert_eq!(left, None);
    let times = job_scheduler::run(&jobs).unwrap();
    let named = names.iter().zip(&times);
    let mut dependent: Vec<_> = named
        .map(|(job, at)| (*job, at.begin_ns as u64, at.end_ns as u64))
        .collect();
    dependent.sort_unstable();
    [timed, dependent]
}

proptest! {
    /// Where each frame is rendered as a whole, both executors give every job the same begin and
    /// end.
    #[test]
    fn both_executors_keep_one_set_of_rules(
        window in 1usize..5,
        references in 1usize..6,
        rest in 0usize..4,
        slots in 1usize..4,
        lead in 0usize..6,
        times in [0u64..40, 0u64..40],
    ) {
        let frames = (references - 1) * window + 1 + rest.min(window - 1);
        let known: Vec<usize> = (0..references).map(|r| (r * window).saturating_sub(lead)).collect();
        let [timed, dependent] = ends(window, &known, frames, slots, times);
        prop_assert_eq!(timed.len(), frames + references);
        prop_assert_eq!(timed, dependent);
    }
}
