//! Random tasks of cells.

use potamoi_formats::config::Config;
use potamoi_formats::rit::{RitEntry, Vertices};
use potamoi_reference::{GatherTask, weights};
use rand::Rng;
use rand_pcg::Pcg64Mcg;

/// A task of cells in what a grid leaves of an MVoxel: `own` vertices an edge.
pub(crate) fn cells(
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
