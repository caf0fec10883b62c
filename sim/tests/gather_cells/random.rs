//! Random tasks of cells, and their check on a unit.

use potamoi_formats::config::{Config, EntryKind};
use potamoi_formats::rit::{RitEntry, Vertices};
use potamoi_golden::units::GatherTask;
use potamoi_golden::units::gather::GatherTwin;
use potamoi_golden::units::weights;
use potamoi_sim::cycles::{Stalls, StreamStalls};
use potamoi_sim::rtl::{Check, GatherTotals, GatherUnit, GatherWork};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::{AGAIN, config};

/// A task of cells in what a grid leaves of an MVoxel: `own` vertices an edge.
pub(super) fn cells(
    random: &mut Pcg64Mcg,
    config: &Config,
    vertices: Vertices,
    (channels, entries): (usize, usize),
) -> GatherTask {
    let axes = vertices.log2();
    let full = config.mvoxel.edges(axes).unwrap();
    let mut own = full;
    for edge in own.iter_mut().take(axes as usize) {
        *edge = [*edge, random.random_range(2..=*edge)][random.random_range(0..2)];
    }
    let bits = config.gu.feature_bits;
    let top = 1i32 << (bits - 1);
    let mut last = 0;
    let entries = (0..entries).map(|_| {
        let mut at = [0; 3];
        let mut fraction = [0u16; 3];
        for axis in 0..axes as usize {
            at[axis] = random.random_range(0..own[axis] - 1);
            fraction[axis] = match random.random_range(0..4) {
                0 => 0,
                1 => 4096,
                _ => random.random_range(0..=4096),
            };
        }
        let mut entry = RitEntry {
            slot: random.random_range(0..=0xffff),
            rows: [0; 8],
            weights: [0; 8],
        };
        let w = config.gu.weight_bits;
        match vertices {
            Vertices::One => {}
            Vertices::Two => entry.weights[..2].copy_from_slice(&weights::linear(fraction[0], w)),
            Vertices::Four => {
                let [x, y, _] = fraction;
                entry.weights[..4].copy_from_slice(&weights::bilinear([x, y], w));
            }
            Vertices::Eight => entry.weights = weights::trilinear(fraction, w),
        }
        for v in 0..vertices.count() {
            let place = [0, 1, 2].map(|axis| at[axis] + (v >> axis & 1));
            entry.rows[v] = (place[0] + own[0] * (place[1] + own[1] * place[2])) as u16;
            last = last.max(entry.rows[v]);
        }
        if vertices == Vertices::One {
            entry.rows[0] = random.random_range(0..40);
            last = last.max(entry.rows[0]);
        }
        entry
    });
    let entries = entries.collect();
    let codes = (usize::from(last) + 1) * channels;
    let mut code = || match random.random_range(0..10) {
        0 => (top - 1) as i16,
        1 => (-top) as i16,
        _ => random.random_range(-top..top) as i16,
    };
    GatherTask {
        vertices,
        channels,
        rows: (0..codes).map(|_| code()).collect(),
        entries,
    }
}

pub(super) fn check(
    config: &Config,
    unit: &GatherUnit,
    tasks: &[GatherTask],
    stalls: Stalls,
) -> GatherTotals {
    let twin = GatherTwin::new(config);
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
