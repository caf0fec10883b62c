//! Schedules worked out by hand, and refused inputs.
#![allow(clippy::unwrap_used)]

mod any;
mod chrome_trace;
mod live;
mod refused;

use glam::DVec3;
use potamoi_base::camera::Camera;
use potamoi_warp::{Counts, Plan, PlanOptions, ReferenceFrom};

use super::*;

pub(super) fn path(frames: usize) -> Vec<Camera> {
    (0..frames)
        .map(|k| {
            let eye = DVec3::new(k as f64 * 0.2, 0.0, -5.0);
            Camera::look_at(eye, eye + DVec3::Z, DVec3::NEG_Y, 0.9, 8, 6)
        })
        .collect()
}

pub(super) fn plan(
    frames: usize,
    window: u32,
    reference: ReferenceFrom,
    lead: Option<u32>,
) -> Plan {
    let options = PlanOptions {
        window,
        reference,
        lead,
    };
    Plan::new(&path(frames), &options).unwrap()
}

pub(super) fn predicted(frames: usize, window: u32, lead: Option<u32>) -> Plan {
    plan(frames, window, ReferenceFrom::Predicted, lead)
}

/// Counts of frames without fallback.
pub(super) fn warped(frames: usize) -> Vec<Counts> {
    vec![Counts::default(); frames]
}

pub(super) const CLOCK: FixedClock = FixedClock {
    reference: 40,
    served: 8,
    target: 10,
    full: 30,
};

fn run(plan: &Plan, options: &Options, remote: Option<&Remote>) -> Schedule {
    schedule(plan, &warped(plan.targets.len()), &CLOCK, options, remote).unwrap()
}

pub(super) fn find(schedule: &Schedule, job: Job) -> Task {
    let found: Vec<_> = schedule.tasks.iter().filter(|t| t.job == job).collect();
    assert_eq!(found.len(), 1, "{job:?}");
    *found[0]
}

fn when(schedule: &Schedule, job: Job) -> [Nanos; 2] {
    let task = find(schedule, job);
    [task.start, task.end]
}

pub(super) fn remote() -> Remote {
    Remote {
        link: Link {
            bytes_per_second: 1_000_000_000,
            latency: 3,
            nanojoules_per_byte: 100,
        },
        request_bytes: 1,
        reference_bytes: 20,
        timeout: 1000,
        lost: [].into(),
    }
}

#[test]
fn without_a_lead_each_window_waits_for_its_reference() {
    let schedule = run(
        &predicted(12, 4, Some(0)),
        &Options::new(Poses::OnShown),
        None,
    );
    assert_eq!(when(&schedule, Job::Reference(1)), [70, 110]);
    assert_eq!(when(&schedule, Job::Reference(2)), [150, 190]);
    assert_eq!(schedule.totals.shown, 230);
    assert_eq!(schedule.totals.overlap, 0);
    for frame in &schedule.frames {
        let first = frame.number % 4 == 0;
        let expected = if first { 40 } else { 0 };
        assert_eq!(
            frame.waits,
            Waits {
                reference: expected,
                ..Waits::default()
            }
        );
    }
}

#[test]
fn a_lead_of_a_window_hides_the_reference_behind_the_window_before() {
    let schedule = run(&predicted(12, 4, None), &Options::new(Poses::OnShown), None);
    // Five poses are known no sooner; then there is no stall any more.
    assert_eq!(when(&schedule, Job::Reference(1)), [70, 110]);
    assert_eq!(when(&schedule, Job::Reference(2)), [110, 150]);
    assert_eq!(when(&schedule, Job::Target(8)), [150, 160]);
    assert_eq!(schedule.totals.shown, 190);
    assert_eq!(schedule.totals.overlap, 40);
    assert_eq!(schedule.totals.frame_waits.reference, 80);
    assert_eq!(schedule.utilisation(Resource::Full), Some(120.0 / 190.0));
    // The second slot is that of reference 1; 2 has that of 0, free since 70.
    assert_eq!(find(&schedule, Job::Reference(2)).slot, Some(0));
    let waits = find(&schedule, Job::Reference(2)).waits;
    assert_eq!(
        waits,
        Waits {
            renderer: 40,
            ..Waits::default()
        }
    );
}

#[test]
fn one_renderer_for_both_does_one_after_the_other() {
    let options = Options {
        concurrent: false,
        ..Options::new(Poses::AtOnce)
    };
    let schedule = run(&predicted(12, 4, None), &options, None);
    // 3 references, and 11 targets, as the first reference is one.
    assert_eq!(schedule.totals.span, 3 * 40 + 11 * 10);
    assert_eq!(schedule.totals.overlap, 0);
    assert_eq!(schedule.utilisation(Resource::Shared), Some(1.0));
    let apart = run(&predicted(12, 4, None), &Options::new(Poses::AtOnce), None);
    assert_eq!(apart.totals.span, 3 * 40 + 4 * 10);
    assert_eq!(apart.totals.overlap, 70);
}

#[test]
fn a_reference_waits_until_a_slot_is_read() {
    let slow = FixedClock {
        reference: 5,
        ..CLOCK
    };
    let plan = predicted(16, 4, None);
    let run = |slots| {
        let options = Options {
            slots,
            ..Options::new(Poses::AtOnce)
        };
        schedule(&plan, &warped(16), &slow, &options, None).unwrap()
    };
    // Reference 0 is read until 35.
    let two = run(2);
    assert_eq!(when(&two, Job::Reference(1)), [5, 10]);
    let third = find(&two, Job::Reference(2));
    assert_eq!(
        [third.start, third.waits.buffer, third.waits.renderer],
        [35, 35, 0]
    );
    assert_eq!(
        third.idle,
        Waits {
            buffer: 25,
            ..Waits::default()
        }
    );
    assert_eq!(two.totals.reference_waits.buffer, 35 + 75);
    assert_eq!(two.totals.shown, 155);
    // With one slot, no target is rendered beside a reference.
    let one = run(1);
    assert_eq!((one.totals.overlap, one.totals.shown), (0, 170));
    assert_eq!(run(4).totals.reference_waits.buffer, 0);
    assert_eq!(run(usize::MAX).tasks, run(4).tasks);
}

#[test]
fn poses_come_at_their_rate_without_drift() {
    let options = Options::new(Poses::Rate {
        frames: 30,
        seconds: 1,
    });
    let schedule = run(&predicted(91, 6, None), &options, None);
    assert_eq!(schedule.frames[1].pose, 33_333_333);
    assert_eq!(schedule.frames[90].pose, 3_000_000_000);
    assert_eq!(schedule.frames[90].latency(), 10);
    let idle = schedule
        .resources
        .iter()
        .find(|u| u.resource == Resource::Sparse)
        .unwrap()
        .idle;
    assert_eq!(idle.total(), idle.pose);
}

#[test]
fn a_remote_reference_goes_over_the_link_both_ways() {
    let plan = predicted(12, 4, None);
    let schedule = run(&plan, &Options::new(Poses::AtOnce), Some(&remote()));
    assert_eq!(when(&schedule, Job::Request(0)), [0, 1]);
    // The latency of the link: 3.
    assert_eq!(when(&schedule, Job::Reference(0)), [4, 12]);
    assert_eq!(when(&schedule, Job::Answer(0)), [12, 32]);
    assert_eq!(schedule.frames[0].finished, 35);
    assert_eq!(
        schedule.frames[0].waits,
        Waits {
            reference: 12,
            link: 23,
            ..Waits::default()
        }
    );
    assert_eq!(
        find(&schedule, Job::Reference(0)).waits,
        Waits {
            link: 4,
            ..Waits::default()
        }
    );
    assert_eq!(when(&schedule, Job::Target(1)), [35, 45]);
    // The answer has the link; the third request waits for a slot until 65.
    assert_eq!(when(&schedule, Job::Request(1)), [1, 2]);
    assert_eq!(when(&schedule, Job::Answer(1)), [32, 52]);
    let answer = find(&schedule, Job::Answer(1)).waits;
    assert_eq!(
        [answer.link, answer.reference, answer.renderer],
        [17, 15, 0]
    );
    assert_eq!(find(&schedule, Job::Request(2)).waits.buffer, 65);
    assert_eq!(
        schedule.totals.link,
        LinkUse {
            bytes: 63,
            nanojoules: 6300
        }
    );
    let full = schedule
        .resources
        .iter()
        .find(|u| u.resource == Resource::Full)
        .unwrap();
    assert_eq!([full.busy, full.after], [0, schedule.totals.span]);
}

#[test]
fn a_reference_that_never_arrives_is_given_up_and_its_frames_are_rendered() {
    let plan = predicted(12, 4, None);
    let remote = Remote {
        timeout: 100,
        lost: [1].into(),
        ..remote()
    };
    let lossy = run(&plan, &Options::new(Poses::AtOnce), Some(&remote));
    for frame in &lossy.frames {
        let expected = match frame.number {
            0 => FrameOrigin::Reference,
            4..8 => FrameOrigin::FullByLoss,
            _ => FrameOrigin::Warped,
        };
        assert_eq!(frame.made, expected);
    }
    // Asked for at 1.
    assert_eq!(when(&lossy, Job::Fallback(4)), [101, 131]);
    assert_eq!(
        find(&lossy, Job::Fallback(4)).waits,
        Waits {
            loss: 101,
            ..Waits::default()
        }
    );
    assert_eq!(when(&lossy, Job::Fallback(7)), [191, 221]);
    // The third is there before, and shown after.
    assert!(lossy.frames[11].finished < 221 && lossy.frames[8].shown == 221);
    assert_eq!(lossy.totals.link.bytes, 63);
    // One that comes too late is not used; one that was not sent is not.
    let late = Remote {
        timeout: 34,
        lost: [].into(),
        ..remote
    };
    let late = run(&plan, &Options::new(Poses::AtOnce), Some(&late));
    assert!(
        late.frames
            .iter()
            .all(|f| f.made == FrameOrigin::FullByLoss)
    );
    assert_eq!(late.totals.link.bytes, 63);
    let hasty = Remote {
        timeout: 10,
        ..self::remote()
    };
    let hasty = run(&plan, &Options::new(Poses::AtOnce), Some(&hasty));
    assert_eq!(hasty.totals.link.bytes, 3);
    // The second is given up while the first has the link: it is not sent.
    let queued = Remote {
        timeout: 25,
        ..self::remote()
    };
    let queued = run(&plan, &Options::new(Poses::AtOnce), Some(&queued));
    assert_eq!(queued.totals.link.bytes, 43);
    // A server that is still at the first when the others are given up does not begin them.
    let busy = Remote {
        timeout: 50,
        ..self::remote()
    };
    let slow = FixedClock {
        served: 100,
        ..CLOCK
    };
    let options = Options::new(Poses::AtOnce);
    let busy = schedule(&plan, &warped(12), &slow, &options, Some(&busy)).unwrap();
    let begun = busy.tasks.iter().filter(|t| t.resource == Resource::Server);
    assert_eq!(begun.count(), 1);
    // In time, to the nanosecond.
    let kept = Remote {
        timeout: 35,
        ..self::remote()
    };
    let kept = run(&plan, &Options::new(Poses::AtOnce), Some(&kept));
    assert_eq!(kept.frames[0].made, FrameOrigin::Reference);
}

#[test]
fn what_a_frame_needs_sooner_goes_first() {
    let options = Options {
        concurrent: false,
        ..Options::new(Poses::AtOnce)
    };
    let remote = Remote {
        timeout: 50,
        lost: [1].into(),
        ..remote()
    };
    let schedule = run(&predicted(12, 4, None), &options, Some(&remote));
    // Frame 4 could be begun at 51.
    assert_eq!(when(&schedule, Job::Target(3)), [55, 65]);
    assert_eq!(when(&schedule, Job::Fallback(4)), [65, 95]);
}

#[test]
fn too_large_an_angle_is_found_by_warping_and_rendered_in_full() {
    let plan = predicted(8, 4, None);
    let mut counts = warped(8);
    counts[2].full = 48;
    let options = Options::new(Poses::AtOnce);
    let schedule = schedule(&plan, &counts, &CLOCK, &options, None).unwrap();
    assert_eq!(when(&schedule, Job::Target(2)), [50, 60]);
    // The full renderer is at reference 1 until 80.
    let full = find(&schedule, Job::Fallback(2));
    assert_eq!([full.start, full.end], [80, 110]);
    assert_eq!(
        [full.waits.reference, full.waits.angle, full.waits.renderer],
        [40, 20, 20]
    );
    assert_eq!(schedule.frames[2].made, FrameOrigin::FullByAngle);
    assert_eq!(schedule.frames[3].finished, 70);
    assert_eq!(schedule.frames[3].shown, 110);
}

#[test]
fn references_within_the_window_hold_up_what_is_before_them() {
    let plan = plan(8, 4, ReferenceFrom::Centre, None);
    let rate = Poses::Rate {
        frames: 10_000_000,
        seconds: 1,
    };
    let schedule = run(&plan, &Options::new(rate), None);
    assert_eq!(when(&schedule, Job::Reference(0)), [200, 240]);
    assert_eq!(
        schedule.frames[0].waits,
        Waits {
            reference: 240,
            ..Waits::default()
        }
    );
    assert_eq!(schedule.frames[2].made, FrameOrigin::Reference);
    assert_eq!(
        [schedule.frames[2].finished, schedule.frames[2].shown],
        [240, 260]
    );
    let error = super::schedule(
        &plan,
        &warped(8),
        &CLOCK,
        &Options::new(Poses::OnShown),
        None,
    );
    let error = error.unwrap_err().to_string();
    assert!(
        error.contains("reference 0: known is 2: expected at most 0"),
        "{error}"
    );
}

#[test]
fn paths_of_no_frame_and_of_one_and_windows_and_leads_beyond_them_are_schedules() {
    for poses in [Poses::OnShown, Poses::AtOnce] {
        let options = Options::new(poses);
        let none = run(&predicted(0, 4, None), &options, Some(&remote()));
        assert!(none.tasks.is_empty() && none.frames.is_empty());
        assert_eq!((none.totals.span, none.totals.frames_per_second), (0, None));
        let one = run(&predicted(1, 4, None), &options, None);
        assert_eq!((one.tasks.len(), one.totals.shown), (1, 40));
        assert_eq!(one.frames[0].made, FrameOrigin::Reference);
        let short = run(&predicted(3, 16, None), &options, None);
        assert_eq!((short.held.len(), short.totals.shown), (1, 60));
        let early = run(&predicted(6, 2, Some(1000)), &options, None);
        assert_eq!(early.frames.len(), 6);
    }
}
