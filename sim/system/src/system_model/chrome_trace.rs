//! Chrome trace of jobs.

use std::collections::BTreeSet;

use serde_json::{Value, json};

use super::job_scheduler::Shared;
use super::outcome::Timeline;
use crate::trace_events::TraceEvents;

/// Writes jobs as a Chrome trace: one track per resource, each job a complete event with its waits
/// as arguments. Counters show how many jobs move bytes through memory, the interconnect and the
/// buffers' ports. Times are microseconds.
#[must_use]
pub fn chrome_trace(timeline: &Timeline) -> Value {
    let mut trace = TraceEvents::new("potamoi model");
    let mut tracks: Vec<_> = timeline.iter().map(|(job, _)| job.resource).collect();
    tracks.sort_unstable();
    tracks.dedup();
    for (at, resource) in tracks.iter().enumerate() {
        trace.track(at + 1, resource);
    }
    for (id, (job, at)) in timeline.iter().enumerate() {
        let track = tracks
            .iter()
            .position(|own| *own == job.resource)
            .unwrap_or(0);
        trace.span(
            (track + 1, at.begin_ns * 1e-3),
            (at.end_ns - at.begin_ns) * 1e-3,
            (job.stage, None),
            json!({
                "job": id,
                "after": job.after,
                "frame": job.rank,
                "waited_for_resource_ns": at.begin_ns - at.ready_ns,
                "waited_for_memory_ns": at.end_ns - at.own_done_ns,
                "own_ns": job.own_ns,
                "memory_alone_ns": job.alone_ns(Shared::Memory),
            }),
        );
    }
    let shares = timeline.iter().flat_map(|(job, _)| &job.shares);
    let shared: BTreeSet<Shared> = shares.map(|share| share.of).collect();
    for of in shared {
        for (us, moving) in moving(timeline, of) {
            let jobs = json!({"jobs that move bytes": moving});
            trace.counter(us, &name(of), jobs);
        }
    }
    trace.finish()
}

fn name(of: Shared) -> String {
    match of {
        Shared::Memory => "memory".to_owned(),
        Shared::Interconnect => "interconnect".to_owned(),
        Shared::Features(group) => format!("feature buffer, group {group}"),
        Shared::Weights => "weight buffer".to_owned(),
    }
}

/// Times at which the number of jobs on a shared channel changes, with the new number.
fn moving(timeline: &Timeline, of: Shared) -> Vec<(f64, i64)> {
    let through = timeline.iter().flat_map(|(job, at)| {
        let own = job.shares.iter().zip(&at.through_ns);
        own.filter(|(share, _)| share.of == of)
            .map(|(_, through)| (at.begin_ns, *through))
    });
    let mut changes: Vec<(f64, i64)> = through
        .filter(|(begin, through)| through > begin)
        .flat_map(|(begin, through)| [(begin, 1), (through, -1)])
        .collect();
    changes.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut levels: Vec<(f64, i64)> = vec![];
    let mut now = 0;
    for (ns, change) in changes {
        now += change;
        match levels.last_mut() {
            Some((us, level)) if *us == ns * 1e-3 => *level = now,
            _ => levels.push((ns * 1e-3, now)),
        }
    }
    levels
}
