//! Checked windows of a plan.

use potamoi_warp::Plan;

use super::{Poses, ScheduleError};
use crate::frame_scheduler::Windows;

/// The windows of a plan. Checks that each reference serves a run of frames, in order, and can
/// begin when the plan says that its pose is known.
pub(super) fn checked(plan: &Plan, poses: Poses) -> Result<Windows, ScheduleError> {
    let mut first = vec![];
    for (number, target) in plan.targets.iter().enumerate() {
        if target.reference == first.len() {
            first.push(number);
        } else if target.reference + 1 != first.len() {
            let next = first.len();
            return Err(ScheduleError::Plan {
                part: "target",
                number,
                field: "reference",
                value: target.reference,
                expected: match next.checked_sub(1) {
                    None => "0".to_owned(),
                    Some(last) => format!("{last} or {next}, as references serve in order"),
                },
            });
        }
    }
    let (named, count) = (first.len(), plan.references.len());
    if named < count {
        return Err(ScheduleError::Plan {
            part: "reference",
            number: named,
            field: "number of targets",
            value: 0,
            expected: "at least 1, or no such reference".to_owned(),
        });
    }
    if named > count {
        return Err(ScheduleError::Plan {
            part: "target",
            number: first[count],
            field: "reference",
            value: count,
            expected: format!("less than {count}, the number of references"),
        });
    }
    let windows = Windows::starting_at(first, plan.targets.len());
    for (number, reference) in plan.references.iter().enumerate() {
        let frames = windows.of(number);
        let refuse = |field, value, expected| {
            Err(ScheduleError::Plan {
                part: "reference",
                number,
                field,
                value,
                expected,
            })
        };
        let known = reference.known;
        if let Some(shown) = reference.target {
            if !frames.contains(&shown) {
                let expected = format!("one of its own frames, {frames:?}");
                return refuse("target", shown, expected);
            }
            if known < shown {
                let expected = format!("at least {shown}, the frame that it shows");
                return refuse("known", known, expected);
            }
        }
        if known >= plan.targets.len() {
            let expected = format!("less than the {} frames", plan.targets.len());
            return refuse("known", known, expected);
        }
        if poses == Poses::OnShown && known > frames.start {
            let expected = format!(
                "at most {}, its first frame, as a pose arrives when the frame before it is \
                     shown; choose a rate, or references that are not of the window's centre",
                frames.start
            );
            return refuse("known", known, expected);
        }
    }
    Ok(windows)
}
