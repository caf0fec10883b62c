//! Buffer space and groups in flight: a job that takes room waits for one that releases it.

use super::*;
use crate::system_model::blocks::blocks;
use crate::system_model::figures;
use crate::system_model::job_scheduler::Times;

/// Timestamps of gathering, computation and compositing, block by block.
fn stages(system: &System, work: &FrameWork) -> [Vec<Times>; 3] {
    let path = path(work, work);
    let model = Model {
        system,
        memory: memory(4),
        costs: costs(Program::of(work)),
        clock_ghz: 1.0,
        weight_bytes: WEIGHTS,
        replay: None,
    };
    let variant = Variant::named("fs+gu").unwrap();
    let (_, timeline) = model.run(&path, variant, Scenario::Local).unwrap();
    ["gathering", "computation", "compositing"].map(|stage| {
        let own = timeline.iter().filter(|(job, _)| job.stage == stage);
        own.map(|(_, at)| at.clone()).collect()
    })
}

fn system(blocks: u64, groups_in_flight: u32) -> System {
    let system = System::default();
    System {
        feature_buffer_bytes: blocks * u64::from(system.feature_block_bytes),
        groups_in_flight,
        ..system
    }
}

/// A block of the feature buffer is filled again after it was read, not before.
#[test]
fn a_block_is_filled_when_it_was_read() {
    let work = figures::frame(true, 9, 4096);
    for held in [2, 4, 48] {
        let [gathered, computed, _] = stages(&system(held as u64, 2), &work);
        let again = computed.iter().zip(&gathered[held..]);
        assert!(again.clone().count() > 0);
        for (read, filled) in again {
            assert!(filled.begin_ns >= read.end_ns, "{held} blocks");
        }
        let mut by_two = computed.iter().zip(&gathered[2..]);
        let is_sooner = by_two.any(|(read, filled)| filled.begin_ns < read.end_ns);
        assert_eq!(is_sooner, held > 2, "{held} blocks");
    }
}

/// A ray group is gathered once the groups in flight before it have determined which rays continue.
#[test]
fn a_group_waits_for_those_in_flight() {
    let work = figures::frame(false, 9, 4096);
    for flight in [1, 2, 3] {
        let system = system(4, flight);
        let cut = blocks(&work, &system);
        let [gathered, _, shown] = stages(&system, &work);
        let mut overlaps = 0;
        // Of the path's first frame.
        for (i, own) in cut.iter().enumerate() {
            for (j, other) in cut.iter().enumerate().filter(|(_, o)| o.group < own.group) {
                let is_over = shown[j].end_ns <= gathered[i].begin_ns;
                assert!(
                    is_over || other.group + flight as usize > own.group,
                    "{flight} in flight: group {} begins before {} is shown",
                    own.group,
                    other.group
                );
                overlaps += u32::from(!is_over);
            }
        }
        assert_eq!(overlaps > 0, flight > 1, "{flight} in flight");
    }
}
