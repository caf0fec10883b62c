//! Turns the dispatcher's record into a schedule.

use potamoi_warp::Plan;

use super::{
    FrameTime, Job, LinkUse, Nanos, Resource, ResourceUse, Schedule, ScheduleError, SlotHold, Task,
    Totals, Waits,
};
use crate::frame_scheduler::{FrameState, Hold};

/// Final state of a dispatcher.
pub(super) struct DispatchRecord {
    pub(super) resources: Vec<Resource>,
    pub(super) tasks: Vec<Task>,
    pub(super) frames: Vec<FrameState<Nanos>>,
    pub(super) waits: Vec<Waits>,
    pub(super) holds: Vec<Hold<Nanos>>,
}

/// Adds waits of another task.
fn add(to: &mut Waits, waits: &Waits, of: &str) -> Result<(), ScheduleError> {
    let fields = [
        (&mut to.pose, waits.pose),
        (&mut to.reference, waits.reference),
        (&mut to.buffer, waits.buffer),
        (&mut to.link, waits.link),
        (&mut to.loss, waits.loss),
        (&mut to.angle, waits.angle),
        (&mut to.renderer, waits.renderer),
    ];
    for (sum, time) in fields {
        *sum = super::clock::later(*sum, time, || format!("what {of} waited for, summed,"))?;
    }
    Ok(())
}

/// The schedule that a dispatcher has recorded.
pub(super) fn finish(
    record: DispatchRecord,
    plan: &Plan,
    link: LinkUse,
) -> Result<Schedule, ScheduleError> {
    let DispatchRecord {
        resources,
        mut tasks,
        frames,
        waits,
        mut holds,
    } = record;
    // Both come in the order in which they ended, and keep it.
    tasks.sort_by_key(|t| t.start);
    holds.sort_by_key(|h| h.from);
    let frames = frames.iter().enumerate().map(|(number, state)| {
        let (Some(pose), Some((finished, made)), Some(shown)) =
            (state.pose, state.finished, state.shown)
        else {
            return Err(ScheduleError::Unfinished { frame: number });
        };
        let reference = plan.targets[number].reference;
        Ok(FrameTime {
            number,
            reference,
            made,
            pose,
            finished,
            shown,
            waits: waits[number],
        })
    });
    let frames = frames.collect::<Result<Vec<_>, _>>()?;

    let shown = frames.last().map_or(0, |f| f.shown);
    let span = tasks.iter().map(|t| t.end).fold(shown, Nanos::max);
    let mut frame_waits = Waits::default();
    for frame in &frames {
        add(&mut frame_waits, &frame.waits, "frames")?;
    }
    let mut reference_waits = Waits::default();
    for task in &tasks {
        if matches!(task.job, Job::Reference(_)) {
            add(&mut reference_waits, &task.waits, "references")?;
        }
    }
    let latencies: u128 = frames.iter().map(|f| u128::from(f.latency())).sum();
    // A mean is no more than the largest.
    let latency_mean = (latencies / (frames.len().max(1) as u128)) as Nanos;
    let totals = Totals {
        span,
        shown,
        frames_per_second: (shown > 0).then(|| frames.len() as f64 * 1e9 / shown as f64),
        latency_max: frames.iter().map(FrameTime::latency).max().unwrap_or(0),
        latency_mean,
        frame_waits,
        reference_waits,
        overlap: overlap(&tasks),
        link,
    };
    let resources = resources
        .into_iter()
        .map(|r| use_of(r, &tasks, span))
        .collect::<Result<_, _>>()?;
    Ok(Schedule {
        tasks,
        frames,
        held: holds.into_iter().map(SlotHold::from).collect(),
        resources,
        totals,
    })
}

fn use_of(resource: Resource, tasks: &[Task], span: Nanos) -> Result<ResourceUse, ScheduleError> {
    let (mut busy, mut idle, mut last) = (0, Waits::default(), 0);
    for task in tasks.iter().filter(|t| t.resource == resource) {
        // One after another, they are held by the span.
        busy += task.end - task.start;
        add(&mut idle, &task.idle, "a resource")?;
        last = task.end;
    }
    Ok(ResourceUse {
        resource,
        busy,
        idle,
        after: span - last,
    })
}

/// Nanoseconds in which a reference and a target were rendered at once.
fn overlap(tasks: &[Task]) -> Nanos {
    let union = |of: fn(Job) -> bool| {
        let mut all: Vec<[Nanos; 2]> = vec![];
        for task in tasks.iter().filter(|t| of(t.job)) {
            match all.last_mut() {
                Some(last) if task.start <= last[1] => last[1] = last[1].max(task.end),
                _ => all.push([task.start, task.end]),
            }
        }
        all
    };
    let references = union(|job| matches!(job, Job::Reference(_)));
    let targets = union(|job| matches!(job, Job::Target(_) | Job::Fallback(_)));
    let (mut total, mut r, mut t) = (0, 0, 0);
    while let (Some(a), Some(b)) = (references.get(r), targets.get(t)) {
        total += a[1].min(b[1]).saturating_sub(a[0].max(b[0]));
        if a[1] < b[1] {
            r += 1;
        } else {
            t += 1;
        }
    }
    total
}
