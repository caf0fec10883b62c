//! Random tasks of the gathering unit, and what must come of them.

use potamoi_cycles::{Stalls, StreamStalls};
use potamoi_formats::config::Config;
use potamoi_formats::fixed::{Rounding, round_shift};
use potamoi_formats::rit::{RitEntry, Vertices};
use potamoi_reference::GatherTask;
use rand::Rng;
use rand_pcg::Pcg64Mcg;

/// Weights of `vertices` that sum to exactly 1: cuts of the unit interval.
fn weights(random: &mut Pcg64Mcg, bits: u32, vertices: Vertices) -> [u16; 8] {
    let one = 1u32 << bits;
    let mut cuts: Vec<u32> = (1..vertices.count())
        .map(|_| random.random_range(0..=one))
        .collect();
    cuts.push(one);
    cuts.sort_unstable();
    let mut out = [0; 8];
    let mut low = 0;
    for (w, cut) in out.iter_mut().zip(cuts) {
        *w = (cut - low) as u16;
        low = cut;
    }
    out
}

/// A task of random rows and entries.
pub(crate) fn task(
    random: &mut Pcg64Mcg,
    config: &Config,
    vertices: Vertices,
    channels: usize,
    rows: usize,
    entries: usize,
) -> GatherTask {
    let top = 1i32 << (config.gu.feature_bits - 1);
    let rows_data = (0..rows * channels)
        .map(|_| match random.random_range(0..10) {
            0 => (top - 1) as i16,
            1 => (-top) as i16,
            _ => random.random_range(-top..top) as i16,
        })
        .collect();
    let entries = (0..entries)
        .map(|_| {
            let mut entry = RitEntry {
                slot: random.random_range(0..=0xffff),
                rows: [0; 8],
                weights: [0; 8],
            };
            for row in entry.rows.iter_mut().take(vertices.count()) {
                *row = random.random_range(0..rows) as u16;
            }
            if vertices.is_structured() {
                entry.weights = weights(random, config.gu.weight_bits, vertices);
            }
            entry
        })
        .collect();
    GatherTask {
        vertices,
        channels,
        rows: rows_data,
        entries,
    }
}

/// What the unit must give, in i128 arithmetic.
pub(crate) fn expected(config: &Config, task: &GatherTask) -> Vec<i16> {
    let top = 1i128 << (config.gu.feature_bits - 1);
    let mut out = vec![];
    for entry in &task.entries {
        for c in 0..task.channels {
            let feature =
                |v: usize| i128::from(task.rows[entry.rows[v] as usize * task.channels + c]);
            let value = if task.vertices.is_structured() {
                let sum: i128 = (0..task.vertices.count())
                    .map(|v| feature(v) * i128::from(entry.weights[v]))
                    .sum();
                round_shift(sum, config.gu.weight_bits, Rounding::HalfEven).clamp(-top, top - 1)
            } else {
                feature(0)
            };
            out.push(value as i16);
        }
    }
    out
}

/// Stalls of every stream, from none to nearly always, single or in bursts.
pub(crate) fn held_up(random: &mut Pcg64Mcg) -> Stalls {
    let mut stream = || StreamStalls {
        per_mille: random.random_range(0..900),
        burst: [1, 1, 2, 9][random.random_range(0..4)],
    };
    Stalls {
        rit: stream(),
        mft: stream(),
        sink: stream(),
    }
}
