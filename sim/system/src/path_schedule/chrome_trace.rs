//! Chrome trace of a schedule.

use serde_json::{Map, Value, json};

use super::{Job, Nanos, Resource, Schedule, Task, Waits};
use crate::trace_events::TraceEvents;

/// Track of shown frames. Those of resources have the indices of [`Resource::ALL`] plus 1.
const DISPLAY: usize = Resource::ALL.len() + 1;
const FIRST_SLOT: usize = DISPLAY + 1;

/// Writes a schedule as a Chrome trace: one track per resource with its tasks as complete events,
/// one per slot of the reference buffer with its holders, and one with the frames as they are
/// shown. An arrow leads from each reference to each of its targets. Times are microseconds with
/// three decimals, exact below 2^53 nanoseconds (104 days). The arguments of a task are its frame,
/// its reference and its waits in nanoseconds.
#[must_use]
pub fn chrome_trace(schedule: &Schedule) -> Value {
    let mut trace = TraceEvents::new("potamoi runtime");
    for used in &schedule.resources {
        trace.track(used.resource as usize + 1, used.resource.name());
    }
    trace.track(DISPLAY, "display");
    let slots = schedule.held.iter().map(|h| h.slot + 1).max().unwrap_or(0);
    for slot in 0..slots {
        trace.track(FIRST_SLOT + slot, format!("reference buffer, slot {slot}"));
    }

    for task in &schedule.tasks {
        let mut args = Map::new();
        match task.job {
            Job::Target(frame) | Job::Fallback(frame) => {
                args.insert("frame".into(), frame.into());
                args.insert("reference".into(), schedule.frames[frame].reference.into());
            }
            Job::Request(r) | Job::Reference(r) | Job::Answer(r) => {
                args.insert("reference".into(), r.into());
            }
        }
        if let Some(slot) = task.slot {
            args.insert("slot".into(), slot.into());
        }
        args.insert("pose_ns".into(), task.asked.into());
        args.insert("waited_ns".into(), waits(&task.waits));
        args.insert("idle_before_ns".into(), waits(&task.idle));
        let (name, category) = name(task.job);
        let us = micros(task.end - task.start);
        let named = (&*name, Some(category));
        trace.span((track(task), micros(task.start)), us, named, args.into());
    }
    for held in &schedule.held {
        let name = format!("reference {}", held.reference);
        trace.span(
            (FIRST_SLOT + held.slot, micros(held.from)),
            micros(held.until - held.from),
            (&name, Some("buffer")),
            json!({"reference": held.reference}),
        );
    }
    for frame in &schedule.frames {
        let name = format!("frame {}", frame.number);
        let args = json!({
            "frame": frame.number, "reference": frame.reference, "made": frame.made,
            "pose_ns": frame.pose, "finished_ns": frame.finished,
            "latency_ns": frame.latency(), "waited_ns": waits(&frame.waits),
        });
        trace.instant((DISPLAY, micros(frame.shown)), (&name, "frame"), args);
    }
    arrows(schedule, &mut trace);
    trace.finish()
}

/// A pair of flow events for each target that read its reference. The first lies in the last
/// nanosecond of the task that produced the reference: at its end it would belong to the next task.
fn arrows(schedule: &Schedule, trace: &mut TraceEvents) {
    let mut brought: Vec<Option<&Task>> = vec![];
    for task in &schedule.tasks {
        if let Job::Reference(r) | Job::Answer(r) = task.job {
            if brought.len() <= r {
                brought.resize(r + 1, None);
            }
            // An answer begins after its reference has ended.
            brought[r] = Some(task);
        }
    }
    for task in &schedule.tasks {
        let Job::Target(frame) = task.job else {
            continue;
        };
        let reference = schedule.frames[frame].reference;
        let Some(from) = brought.get(reference).copied().flatten() else {
            continue;
        };
        let inside = from.end.saturating_sub(1).max(from.start);
        let name = format!("reference {reference}");
        let from = (track(from), micros(inside));
        let to = (track(task), micros(task.start));
        trace.arrow(from, to, (&name, "reference"), frame);
    }
}

const fn track(task: &Task) -> usize {
    task.resource as usize + 1
}

fn name(job: Job) -> (String, &'static str) {
    match job {
        Job::Request(r) => (format!("request {r}"), "link"),
        Job::Reference(r) => (format!("reference {r}"), "reference"),
        Job::Answer(r) => (format!("answer {r}"), "link"),
        Job::Target(frame) => (format!("target {frame}"), "target"),
        Job::Fallback(frame) => (format!("full {frame}"), "fallback"),
    }
}

fn micros(time: Nanos) -> f64 {
    time as f64 / 1e3
}

/// Waits that are not 0.
fn waits(waits: &Waits) -> Value {
    let causes = waits.named().into_iter().filter(|(_, time)| *time > 0);
    Value::Object(
        causes
            .map(|(cause, time)| (cause.to_owned(), time.into()))
            .collect(),
    )
}
