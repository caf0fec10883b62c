//! Live execution: real threads, real frames, a renderer of random speed.

use std::collections::BTreeSet;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc;
use std::time::Duration;

use glam::DVec3;
use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;
use potamoi_warp::{
    Frame, Plan, Profile, ReferenceFrom, Renderer, Rule, Scope, Sequence, Shaded, WarpError, Warper,
};

use super::super::*;
use super::{path, plan, predicted};

/// Two planes, one before the other, with view-dependent colour.
#[derive(Default)]
struct Planes {
    /// Largest random delay of a call, in microseconds.
    slow: u64,
    /// Further delay where no mask is given.
    full: u64,
    /// The calls that fail and that panic, counted from 1.
    fails: Option<u64>,
    panics: Option<u64>,
    calls: AtomicU64,
}

impl Renderer for Planes {
    fn background(&self) -> [f32; 3] {
        [0.25; 3]
    }

    fn bounds(&self) -> Option<[DVec3; 2]> {
        None
    }

    fn shade(&self, camera: &Camera, only: Option<&Mask>) -> Result<Shaded, WarpError> {
        let call = self.calls.fetch_add(1, Ordering::Relaxed) + 1;
        if self.slow > 0 {
            // Steps of the golden ratio: no order that the threads could keep to.
            let time = ((call.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) * self.slow) >> 32;
            let more = if only.is_none() { self.full } else { 0 };
            std::thread::sleep(Duration::from_micros(time + more));
        }
        assert_ne!(
            Some(call),
            self.panics,
            "the renderer panics as it was told to"
        );
        if Some(call) == self.fails {
            return Err(WarpError::NotTaken {
                sequence: "planes".to_owned(),
            });
        }
        let count = (camera.width * camera.height) as usize;
        let mut picture = Picture::filled(camera.width, camera.height, self.background());
        let mut depth = vec![f32::INFINITY; count];
        for pixel in (0..count).filter(|p| only.is_none_or(|mask| mask.has(*p))) {
            let (eye, towards) =
                camera.ray(pixel as u32 % camera.width, pixel as u32 / camera.width);
            let near = eye + towards * ((-1.0 - eye.z) / towards.z);
            let at = if near.x > 0.3 {
                near
            } else {
                eye + towards * (-eye.z / towards.z)
            };
            picture.rgb[pixel] = [at.x, at.y, eye.x].map(|v| v as f32);
            depth[pixel] = (at.z - eye.z) as f32;
        }
        Ok(Shaded { picture, depth })
    }
}

/// References of which some never arrive.
struct Lossy<'a>(Warper<'a>, &'a [usize]);

impl References for Lossy<'_> {
    fn reference(&self, number: usize, camera: &Camera) -> Result<Option<Shaded>, WarpError> {
        let lost = self.1.contains(&number);
        let shaded = self.0.reference(camera)?;
        Ok((!lost).then_some(shaded))
    }
}

fn warper(renderer: &Planes, phi: Option<f64>) -> Warper<'_> {
    let rule = Rule {
        phi,
        scope: Scope::Frame,
        ..Profile::Paper.rule()
    };
    Warper {
        renderer,
        geometry: None,
        rule,
    }
}

fn options(poses: Poses, concurrent: bool, slots: usize) -> Options {
    Options {
        poses,
        concurrent,
        slots,
    }
}

fn run(
    renderer: &Planes,
    phi: Option<f64>,
    plan: &Plan,
    options: &Options,
    lost: &[usize],
) -> Result<(Vec<Frame>, Schedule), ScheduleError> {
    let warper = warper(renderer, phi);
    let path = path(plan.targets.len());
    let mut frames = vec![];
    let references = Lossy(warper, lost);
    let schedule = live(warper, &references, &path, plan, options, |frame| {
        frames.push(frame)
    })?;
    Ok((frames, schedule))
}

/// Runs `what`, and fails the test if it does not end.
fn ends<T: Send + 'static>(what: impl FnOnce() -> T + Send + 'static) -> std::thread::Result<T> {
    let (done, wait) = mpsc::channel();
    let thread = std::thread::spawn(move || {
        let result = std::panic::catch_unwind(std::panic::AssertUnwindSafe(what));
        let _ = done.send(result);
    });
    let result = wait.recv_timeout(Duration::from_secs(60)).unwrap();
    thread.join().unwrap();
    result
}

/// Invariants of every measured schedule.
fn check(schedule: &Schedule) {
    for used in &schedule.resources {
        let mut free = 0;
        for task in schedule
            .tasks
            .iter()
            .filter(|t| t.resource == used.resource)
        {
            assert!(task.start >= free && task.end >= task.start);
            assert_eq!(free + task.idle.total(), task.start);
            assert_eq!(task.asked + task.waits.total(), task.start);
            free = task.end;
        }
        assert_eq!(
            used.busy + used.idle.total() + used.after,
            schedule.totals.span
        );
    }
    for task in &schedule.tasks {
        let Job::Target(frame) = task.job else {
            continue;
        };
        let wanted = schedule.frames[frame].reference;
        let reference = super::find(schedule, Job::Reference(wanted));
        assert!(reference.end <= task.start);
        let held = schedule
            .held
            .iter()
            .find(|h| h.reference == wanted)
            .unwrap();
        assert!(held.from <= reference.start && task.end <= held.until);
    }
    assert!(
        schedule
            .frames
            .windows(2)
            .all(|pair| pair[0].shown <= pair[1].shown)
    );
    for (n, held) in schedule.held.iter().enumerate() {
        let others = schedule.held[..n].iter();
        let mut others = others.filter(|h| h.slot == held.slot);
        assert!(others.all(|h| h.until <= held.from || held.until <= h.from));
    }
}

#[test]
fn frames_are_those_of_the_sequence_whatever_takes_how_long() {
    let rate = Poses::Rate {
        frames: 2000,
        seconds: 1,
    };
    let mut made = BTreeSet::new();
    for (from, lead) in [
        (ReferenceFrom::Predicted, None),
        (ReferenceFrom::Predicted, Some(0)),
        (ReferenceFrom::First, None),
        (ReferenceFrom::Centre, None),
    ] {
        for (phi, lost) in [(None, &[][..]), (Some(0.025), &[][..]), (None, &[0, 2])] {
            for (poses, concurrent, slots) in [
                (Poses::AtOnce, true, 2),
                (Poses::OnShown, true, 2),
                (rate, true, 3),
                (Poses::AtOnce, false, 1),
            ] {
                if from == ReferenceFrom::Centre && poses == Poses::OnShown {
                    continue;
                }
                let plan = plan(23, 5, from, lead);
                let still = Planes::default();
                let path = path(23);
                let sequence = Sequence::new(warper(&still, phi), &path, &plan, lost);
                let expected: Vec<Frame> = sequence.map(Result::unwrap).collect();
                let slow = Planes {
                    slow: 600,
                    ..Planes::default()
                };
                let options = options(poses, concurrent, slots);
                let (frames, schedule) = run(&slow, phi, &plan, &options, lost).unwrap();
                assert!(frames == expected, "{from:?} {poses:?} {phi:?} {lost:?}");
                check(&schedule);
                for (time, frame) in schedule.frames.iter().zip(&frames) {
                    let full =
                        time.made != FrameOrigin::Warped && time.made != FrameOrigin::Reference;
                    assert_eq!(full, frame.fell_back());
                    made.insert(format!("{:?}", time.made));
                }
            }
        }
    }
    // All kinds of frames were among them.
    assert_eq!(made.len(), 4, "{made:?}");
}

#[test]
fn references_and_targets_are_rendered_at_once_and_the_trace_shows_it() {
    let renderer = Planes {
        slow: 2000,
        full: 6000,
        ..Planes::default()
    };
    let plan = predicted(40, 8, None);
    let (_, two) = run(
        &renderer,
        None,
        &plan,
        &options(Poses::AtOnce, true, 2),
        &[],
    )
    .unwrap();
    assert!(two.totals.overlap > 0);
    let trace = chrome_trace(&two);
    assert!(trace["traceEvents"].as_array().unwrap().len() > two.tasks.len());
    let (_, one) = run(
        &renderer,
        None,
        &plan,
        &options(Poses::AtOnce, false, 2),
        &[],
    )
    .unwrap();
    assert_eq!(one.totals.overlap, 0);
}

#[test]
fn an_error_ends_it_wherever_it_is() {
    let right = Planes::default();
    let options_of = options(Poses::OnShown, true, 2);
    run(&right, None, &predicted(20, 4, None), &options_of, &[1]).unwrap();
    let calls = right.calls.into_inner();
    assert!(calls > 12, "{calls}");
    for fails in 1..=calls {
        let result = ends(move || {
            let renderer = Planes {
                slow: 300,
                fails: Some(fails),
                ..Planes::default()
            };
            let options = options(Poses::OnShown, true, 2);
            run(&renderer, None, &predicted(20, 4, None), &options, &[1]).map(drop)
        });
        let error = result.unwrap().unwrap_err();
        assert!(error.to_string().contains("planes"), "{error}");
    }
}

#[test]
fn a_panic_ends_it_too() {
    for panics in [1, 2, 7] {
        let result = ends(move || {
            let renderer = Planes {
                panics: Some(panics),
                ..Planes::default()
            };
            let options = options(Poses::OnShown, true, 2);
            run(&renderer, None, &predicted(20, 4, None), &options, &[]).map(drop)
        });
        assert!(result.is_err());
    }
    let shown = ends(|| {
        let renderer = Planes::default();
        let warper = warper(&renderer, None);
        let plan = predicted(20, 4, None);
        let options = options(Poses::AtOnce, true, 2);
        let show = |frame: Frame| assert!(frame.number < 5, "the display panics as it was told to");
        live(warper, &warper, &path(20), &plan, &options, show).map(drop)
    });
    assert!(shown.is_err());
}

#[test]
fn rendering_pauses_while_frames_are_not_shown() {
    let renderer = Planes::default();
    let warper = warper(&renderer, None);
    let plan = predicted(60, 6, None);
    let show = |_: Frame| std::thread::sleep(Duration::from_millis(3));
    let options = options(Poses::AtOnce, true, 2);
    let schedule = live(warper, &warper, &path(60), &plan, &options, show).unwrap();
    for frame in &schedule.frames {
        let now = frame.finished;
        let kept = schedule
            .frames
            .iter()
            .filter(|f| f.finished <= now && now < f.shown)
            .count();
        // What was begun before is finished on both threads.
        assert!(kept <= super::super::live::AHEAD + 2, "{kept}");
    }
}

#[test]
fn paths_of_no_frame_and_of_one_are_rendered_and_others_than_the_plans_refused() {
    let renderer = Planes::default();
    for frames in [0, 1, 3] {
        let plan = predicted(frames, 16, None);
        let options = options(Poses::OnShown, true, 2);
        let (shown, schedule) = run(&renderer, None, &plan, &options, &[]).unwrap();
        assert_eq!((shown.len(), schedule.frames.len()), (frames, frames));
    }
    let warper = warper(&renderer, None);
    let plan = predicted(4, 2, None);
    let options = options(Poses::AtOnce, true, 2);
    let error = live(warper, &warper, &path(3), &plan, &options, drop).unwrap_err();
    assert!(
        error.to_string().contains("path has 3 entries: expected 4"),
        "{error}"
    );
}
