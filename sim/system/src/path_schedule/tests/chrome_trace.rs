//! Checks of a trace by what its reader sees.

use std::collections::BTreeMap;

use serde_json::Value;

use super::super::*;
use super::{CLOCK, find, predicted, remote, warped};

fn nanos(value: &Value) -> u64 {
    (value.as_f64().unwrap() * 1e3).round() as u64
}

fn events(schedule: &Schedule) -> Vec<Value> {
    let text = chrome_trace(schedule).to_string();
    let trace: Value = serde_json::from_str(&text).unwrap();
    trace["traceEvents"].as_array().unwrap().clone()
}

fn of<'e>(events: &'e [Value], phase: &str) -> Vec<&'e Value> {
    events.iter().filter(|e| e["ph"] == phase).collect()
}

fn schedules() -> Vec<Schedule> {
    let plan = predicted(30, 4, None);
    let mut counts = warped(30);
    counts[9].full = 1;
    let lossy = Remote {
        timeout: 60,
        lost: [2].into(),
        ..remote()
    };
    [
        (true, None),
        (false, None),
        (true, Some(&lossy)),
        (false, Some(&lossy)),
    ]
    .into_iter()
    .map(|(concurrent, remote)| {
        let options = Options {
            concurrent,
            ..Options::new(Poses::OnShown)
        };
        schedule(&plan, &counts, &CLOCK, &options, remote).unwrap()
    })
    .collect()
}

#[test]
fn slices_of_a_track_follow_one_another_and_all_tracks_have_names() {
    for schedule in schedules() {
        let events = events(&schedule);
        let mut tracks: BTreeMap<u64, Vec<[u64; 2]>> = BTreeMap::new();
        let slices = of(&events, "X");
        assert_eq!(slices.len(), schedule.tasks.len() + schedule.held.len());
        for slice in slices {
            let start = nanos(&slice["ts"]);
            let track = tracks.entry(slice["tid"].as_u64().unwrap()).or_default();
            track.push([start, start + nanos(&slice["dur"])]);
        }
        let names: BTreeMap<u64, &str> = of(&events, "M")
            .iter()
            .filter(|e| e["name"] == "thread_name")
            .map(|e| {
                (
                    e["tid"].as_u64().unwrap(),
                    e["args"]["name"].as_str().unwrap(),
                )
            })
            .collect();
        for (track, mut slices) in tracks {
            assert!(names.contains_key(&track), "{track}");
            slices.sort_unstable();
            for pair in slices.windows(2) {
                assert!(pair[0][1] <= pair[1][0], "{}: {pair:?}", names[&track]);
            }
        }
    }
}

#[test]
fn arrows_lead_from_within_references_to_their_targets() {
    for schedule in schedules() {
        let events = events(&schedule);
        let targets = schedule
            .tasks
            .iter()
            .filter(|t| matches!(t.job, Job::Target(_)));
        let (starts, ends) = (of(&events, "s"), of(&events, "f"));
        assert_eq!(starts.len(), targets.count());
        assert!(starts.len() > 10 && starts.len() == ends.len());
        for (start, end) in starts.iter().zip(ends) {
            assert_eq!(start["id"], end["id"]);
            let frame = start["id"].as_u64().unwrap() as usize;
            let target = find(&schedule, Job::Target(frame));
            assert_eq!(nanos(&end["ts"]), target.start);
            assert_eq!(end["tid"], target.resource as usize + 1);
            let reference = schedule.frames[frame].reference;
            let remote = schedule
                .resources
                .iter()
                .any(|u| u.resource == Resource::Link);
            let from = if remote {
                Job::Answer(reference)
            } else {
                Job::Reference(reference)
            };
            let from = find(&schedule, from);
            let at = nanos(&start["ts"]);
            assert!(from.start <= at && at < from.end && from.end <= target.start);
            assert_eq!(start["tid"], from.resource as usize + 1);
        }
    }
}

#[test]
fn times_and_causes_are_those_of_the_schedule() {
    let schedule = &schedules()[0];
    let events = events(schedule);
    let named = |name: &str| events.iter().find(|e| e["name"] == name).unwrap();
    let target = named("target 4");
    let task = find(schedule, Job::Target(4));
    assert_eq!(target["ts"].as_f64(), Some(task.start as f64 / 1000.0));
    assert_eq!(target["dur"].as_f64(), Some(0.01));
    assert_eq!(target["args"]["frame"], 4);
    assert_eq!(target["args"]["reference"], 1);
    assert_eq!(target["args"]["waited_ns"]["reference"], 40);
    assert!(target["args"]["waited_ns"].get("buffer").is_none());
    assert_eq!(named("full 9")["args"]["waited_ns"]["angle"], 10);
    let shown: Vec<u64> = of(&events, "i").iter().map(|e| nanos(&e["ts"])).collect();
    let expected: Vec<u64> = schedule.frames.iter().map(|f| f.shown).collect();
    assert_eq!(shown, expected);
}
