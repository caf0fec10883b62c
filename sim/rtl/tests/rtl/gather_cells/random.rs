//! Random tasks of cells, and their check on a unit.

use potamoi_cycles::{GatherWork, Stalls, StreamStalls};
use potamoi_formats::config::{Config, EntryKind};
use potamoi_formats::rit::Vertices;
use potamoi_reference::GatherTask;
use potamoi_reference::gathering_unit::ReferenceGatheringUnit;
use potamoi_rtl::{Check, GatherTotals, GatherUnit};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;

use super::{AGAIN, config};
use crate::cells::cells;

pub(super) fn check(
    config: &Config,
    unit: &GatherUnit,
    tasks: &[GatherTask],
    stalls: Stalls,
) -> GatherTotals {
    let twin = ReferenceGatheringUnit::new(config);
    let mut features = vec![];
    for task in tasks {
        assert_eq!(twin.gather(task, &mut features).unwrap(), 0);
    }
    let conditions = Check {
        stalls,
        seed: 5,
        flags: 0,
        progress: &mut |_| {},
    };
    let totals = unit.check(config, tasks, &features, conditions);
    let totals = totals.unwrap_or_else(|e| panic!("{config:?}, {stalls:?}: {e}\nagain: {AGAIN}"));
    if stalls == Stalls::NONE {
        let work = GatherWork::new(config, tasks).unwrap();
        let closed = work.predicted(config).unwrap();
        assert_eq!(closed.issue_span(), totals.issue_span());
        assert_eq!(closed.stall_bank, totals.stall_bank);
        assert_eq!(closed.fill, totals.first_issue - totals.first_beat);
        assert_eq!(closed.elapsed, totals.cycles - totals.first_beat);
    }
    totals
}

/// Entries of a half of the RIT buffer.
fn half(config: &Config, vertices: Vertices) -> usize {
    let bytes = match (vertices, config.rit.entry) {
        (Vertices::One, _) => 4,
        (_, EntryKind::Compact) => 8,
        (of, EntryKind::Paper) => 6 * of.count(),
    };
    48 * config.rit.entries as usize / bytes
}

pub(super) fn all(text: &str, sizes: &[(Vertices, usize)]) {
    let config = config(text);
    let unit = GatherUnit::build(&config).unwrap();
    let mut random = Pcg64Mcg::seed_from_u64(9);
    for &(vertices, channels) in sizes {
        // The fourth fills one half of the buffer and a part of the other.
        let counts = [1, 2, 37, half(&config, vertices) * 5 / 4, 300, 5];
        let tasks = counts.map(|n| cells(&mut random, &config, vertices, (channels, n)));
        check(&config, &unit, &tasks, Stalls::NONE);
        let now_and_then = StreamStalls {
            per_mille: 300,
            burst: 3,
        };
        let stalls = Stalls {
            rit: now_and_then,
            mft: now_and_then,
            sink: now_and_then,
        };
        check(&config, &unit, &tasks, stalls);
    }
}
