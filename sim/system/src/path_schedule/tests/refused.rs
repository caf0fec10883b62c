//! Refused: times of zero, overflow, and inconsistent plans.

use potamoi_warp::Plan;

use super::super::*;
use super::{CLOCK, predicted, remote, run, warped};

#[test]
fn no_time_at_all_is_enough() {
    let zero = FixedClock {
        reference: 0,
        served: 0,
        target: 0,
        full: 0,
    };
    let instant = Remote {
        request_bytes: 0,
        reference_bytes: 0,
        link: Link {
            latency: 0,
            ..Link::PAPER
        },
        ..remote()
    };
    for poses in [Poses::OnShown, Poses::AtOnce] {
        for remote in [None, Some(&instant)] {
            let plan = predicted(20, 3, None);
            let options = Options::new(poses);
            let schedule = schedule(&plan, &warped(20), &zero, &options, remote).unwrap();
            assert_eq!((schedule.frames.len(), schedule.totals.shown), (20, 0));
            assert_eq!(schedule.totals.frames_per_second, None);
            assert_eq!(schedule.utilisation(Resource::Full), None);
        }
    }
}

#[test]
fn what_64_bits_do_not_hold_is_named() {
    let plan = predicted(8, 4, None);
    let options = Options::new(Poses::AtOnce);
    let refused = |clock: &FixedClock, options: &Options, remote: Option<&Remote>| {
        let error = schedule(&plan, &warped(8), clock, options, remote).unwrap_err();
        assert!(matches!(error, ScheduleError::Overflow { .. }), "{error}");
        error.to_string()
    };
    let long = FixedClock {
        reference: Nanos::MAX,
        ..CLOCK
    };
    assert!(refused(&long, &options, None).contains("Reference(1)"));
    let one = schedule(&predicted(3, 4, None), &warped(3), &long, &options, None);
    assert!(one.unwrap_err().to_string().contains("Target(1)"));
    let half = FixedClock {
        reference: Nanos::MAX / 2 + 1,
        ..CLOCK
    };
    assert!(refused(&half, &options, None).contains("Reference(1)"));
    // Seven frames that wait for all of 64 bits each.
    let last = FixedClock {
        reference: Nanos::MAX / 4,
        target: 0,
        ..CLOCK
    };
    assert!(refused(&last, &options, None).contains("summed"));
    let mut bytes = remote();
    bytes.request_bytes = 0;
    bytes.reference_bytes = u64::MAX;
    bytes.link.bytes_per_second = 1;
    assert!(refused(&CLOCK, &options, Some(&bytes)).contains("Answer(0)"));
    bytes.request_bytes = 1;
    bytes.link.bytes_per_second = u64::MAX;
    assert!(refused(&CLOCK, &options, Some(&bytes)).contains("traffic"));
    let joules = Remote {
        reference_bytes: u64::MAX / 8,
        ..bytes
    };
    assert!(refused(&CLOCK, &options, Some(&joules)).contains("energy"));
    let patient = Remote {
        timeout: Nanos::MAX,
        ..remote()
    };
    assert!(refused(&CLOCK, &options, Some(&patient)).contains("timeout"));
    let far = Options::new(Poses::Rate {
        frames: 1,
        seconds: u32::MAX,
    });
    assert!(refused(&CLOCK, &far, None).contains("the pose of frame 5"));
    let near = run(&predicted(5, 4, None), &far, None);
    assert!(near.totals.span > 4 * u64::from(u32::MAX) * 1_000_000_000);
}

#[test]
fn options_and_plans_that_cannot_be_are_refused_by_name() {
    let good = predicted(8, 4, None);
    let options = Options::new(Poses::AtOnce);
    let refused = |plan: &Plan, options: &Options, remote: Option<&Remote>, part: &str| {
        let counts = warped(plan.targets.len());
        let error = schedule(plan, &counts, &CLOCK, options, remote)
            .unwrap_err()
            .to_string();
        assert!(error.contains(part), "{error}");
    };
    let mut dead = remote();
    dead.link.bytes_per_second = 0;
    refused(&good, &options, Some(&dead), "link.bytes_per_second");
    refused(
        &good,
        &Options {
            slots: 0,
            ..options
        },
        None,
        "slots",
    );
    let still = Options::new(Poses::Rate {
        frames: 0,
        seconds: 1,
    });
    refused(&good, &still, None, "poses.frames");
    let still = Options::new(Poses::Rate {
        frames: 1,
        seconds: 0,
    });
    refused(&good, &still, None, "poses.seconds");

    let change = |change: fn(&mut Plan), part| {
        let mut plan = good.clone();
        change(&mut plan);
        refused(&plan, &options, None, part);
    };
    change(
        |p| p.targets[0].reference = 1,
        "target 0: reference is 1: expected 0",
    );
    change(
        |p| p.targets[2].reference = 2,
        "target 2: reference is 2: expected 0 or 1",
    );
    change(
        |p| p.targets[6].reference = 0,
        "target 6: reference is 0: expected 1 or 2",
    );
    change(
        |p| {
            p.references.pop();
        },
        "target 4: reference is 1: expected less than 1",
    );
    change(
        |p| p.references.push(p.references[0]),
        "reference 2: number of targets is 0",
    );
    change(|p| p.references[1].known = 8, "reference 1: known is 8");
    change(
        |p| p.references[0].target = Some(5),
        "reference 0: target is 5",
    );
    change(
        |p| p.references[0].target = Some(3),
        "known is 0: expected at least 3",
    );

    let error = schedule(&good, &warped(7), &CLOCK, &options, None).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("counts has 7 entries: expected 8")
    );
    let unfinished = super::super::dispatch::Dispatcher::new(&good, &options, false).unwrap();
    let error = super::super::finish::finish(unfinished.into_record(), &good, LinkUse::default());
    assert!(
        error
            .unwrap_err()
            .to_string()
            .contains("frame 0 was not shown")
    );
}

#[test]
fn bytes_on_the_link_take_time_rounded_up() {
    assert_eq!(Link::PAPER.time(1, "a byte").unwrap(), 100);
    // A raw frame of 800 x 800: 0.192 s, and 0.192 J.
    assert_eq!(
        Link::PAPER.time(800 * 800 * 3, "a frame").unwrap(),
        192_000_000
    );
    let slow = Link {
        bytes_per_second: 3,
        ..Link::PAPER
    };
    assert_eq!(slow.time(1, "a byte").unwrap(), 333_333_334);
}
