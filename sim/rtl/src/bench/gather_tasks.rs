//! Small tasks of the gathering unit that reach its edges: first and last rows, weights of 0 and 1,
//! extreme features, partly filled groups and segments, MVoxels of one entry, of both halves of the
//! RIT buffer, and of more.

use potamoi_formats::config::{Config, EntryKind, Organisation};
use potamoi_formats::rit::{RitEntry, Vertices};
use potamoi_reference::{GatherTask, weights};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Rows of an MVoxel of most jobs, so that files stay small.
const FEW_ROWS: usize = 9;
/// Most digits of the beats of features of a job of many entries.
const MOST_DIGITS: usize = 150_000;

/// Tasks of every job.
pub(super) fn jobs(config: &Config, seed: u64) -> Vec<Vec<GatherTask>> {
    let mut draw = Draw::new(config, seed);
    let side = config.gu.ports as usize;
    let built = config.supported_vertices();
    let mut jobs = vec![];
    // Every entry size twice, and one to four segments.
    for (i, &vertices) in built.iter().chain(built.iter().rev()).enumerate() {
        let segments = (i % 4 + 1).min(config.gu.segments as usize);
        let channels = draw.channels(segments, i % 2 == 0);
        let counts = [1, 2 * side + 1, 4 * side, draw.random.random_range(2..=9)];
        jobs.push(draw.tasks(vertices, channels, FEW_ROWS, &counts));
    }
    if config.gu.records_a_row == 2 && built.contains(&Vertices::One) {
        let channels = config.gu.banks as usize / 2;
        jobs.push(draw.tasks(Vertices::One, channels, FEW_ROWS, &[3, 2 * side + 1]));
    }
    let most = built[built.len() - 1];
    // Of the buffer's halves: one and a part, and both and a part; and MVoxels that end with a half, the third
    // that they fill. These have to have a gap before their last beat in some run.
    let half = config.rit_entries(most) as usize;
    let segments = config.gu.segments.min(2) as usize;
    let digits = config.lanes_a_port() as usize * side * config.feature_lane_bits() as usize / 3;
    for counts in [&[half + 3, 2 * half + 2 * side + 1, 2][..], &[3 * half; 3]] {
        let groups = counts.iter().sum::<usize>().div_ceil(side) * segments;
        if groups * digits <= MOST_DIGITS {
            let channels = draw.channels(segments, false);
            jobs.push(draw.tasks(most, channels, FEW_ROWS, counts));
        }
    }
    jobs
}

/// A source of tasks.
pub(super) struct Draw<'a> {
    pub(super) config: &'a Config,
    pub(super) random: Pcg64Mcg,
}

impl<'a> Draw<'a> {
    pub(super) fn new(config: &'a Config, seed: u64) -> Self {
        let random = Pcg64Mcg::seed_from_u64(seed);
        Self { config, random }
    }

    /// Channels that take so many segments, the last of them whole or in part.
    pub(super) fn channels(&mut self, segments: usize, whole: bool) -> usize {
        let a_segment = match self.config.organisation().0 {
            Organisation::FeatureMajor => self.config.gu.banks,
            _ => self.config.lanes_a_port(),
        } as usize;
        let last = match whole {
            true => a_segment,
            false => self.random.random_range(1..=a_segment),
        };
        (segments - 1) * a_segment + last
    }

    fn tasks(
        &mut self,
        vertices: Vertices,
        channels: usize,
        rows: usize,
        counts: &[usize],
    ) -> Vec<GatherTask> {
        let of = |&count: &usize| self.task(vertices, channels, rows, count);
        counts.iter().map(of).collect()
    }

    pub(super) fn task(
        &mut self,
        vertices: Vertices,
        channels: usize,
        rows: usize,
        count: usize,
    ) -> GatherTask {
        let cells = vertices.is_structured()
            && (self.config.is_parity() || self.config.rit.entry == EntryKind::Compact);
        let capacity = self.config.mvoxel_capacity(vertices, channels) as usize;
        let rows = rows.min(capacity).max(1);
        let mut entries = vec![];
        for i in 0..count {
            // The first and the last row of the MVoxel are among those read.
            let end = [Some(0), Some(usize::MAX)].get(i).copied().flatten();
            let mut entry = match cells {
                true => self.cell(vertices, rows, end),
                false => self.scattered(vertices, rows, end),
            };
            entry.slot = [0, 0xffff]
                .get(i)
                .copied()
                .unwrap_or(self.random.random_range(0..=0xffff));
            entries.push(entry);
        }
        let used = entries
            .iter()
            .flat_map(|e| &e.rows[..vertices.count()])
            .max();
        let loaded = used.map_or(1, |row| usize::from(*row) + 1);
        GatherTask {
            vertices,
            channels,
            rows: (0..loaded * channels).map(|_| self.feature()).collect(),
            entries,
        }
    }

    pub(super) fn feature(&mut self) -> i16 {
        let top = 1i32 << (self.config.gu.feature_bits - 1);
        let code = match self.random.random_range(0..8) {
            0 => top - 1,
            1 => -top,
            2 => self.random.random_range(-2..=2).clamp(-top, top - 1),
            _ => self.random.random_range(-top..top),
        };
        code as i16
    }

    /// Any rows with any weights that sum to 1.
    pub(super) fn scattered(
        &mut self,
        vertices: Vertices,
        rows: usize,
        end: Option<usize>,
    ) -> RitEntry {
        let count = vertices.count();
        let mut entry = RitEntry {
            slot: 0,
            rows: [0; 8],
            weights: [0; 8],
        };
        for row in entry.rows.iter_mut().take(count) {
            let drawn = self.random.random_range(0..rows);
            *row = end.map_or(drawn, |row| row.min(rows - 1)) as u16;
        }
        if !vertices.is_structured() {
            return entry;
        }
        let one = 1u32 << self.config.gu.weight_bits;
        let alone = self.random.random_range(0..count);
        let mut cuts: Vec<u32> = match self.random.random_range(0..4) {
            // One vertex has the whole weight, or two the half each: a tie of the rounding.
            0 => (1..count)
                .map(|v| if v > alone { one } else { 0 })
                .collect(),
            1 => {
                let other = self.random.random_range(0..count);
                let of = |v| one / 2 * (u32::from(v > alone) + u32::from(v > other));
                (1..count).map(of).collect()
            }
            _ => (1..count)
                .map(|_| self.random.random_range(0..=one))
                .collect(),
        };
        cuts.push(one);
        cuts.sort_unstable();
        let mut low = 0;
        for (weight, cut) in entry.weights.iter_mut().zip(cuts) {
            *weight = (cut - low) as u16;
            low = cut;
        }
        entry
    }

    /// A cell of the MVoxel's grid, at the place of its first vertex.
    fn cell(&mut self, vertices: Vertices, rows: usize, end: Option<usize>) -> RitEntry {
        let axes = vertices.log2() as usize;
        let edges = self.config.mvoxel.edges(vertices.log2()).unwrap_or([1; 3]);
        let (mut at, mut fraction) = ([0; 3], [0u16; 3]);
        for axis in 0..axes {
            // Few rows: a corner of the grid.
            let edge = match rows < self.config.mvoxel.rows as usize {
                true => edges[axis].min(3),
                false => edges[axis],
            };
            let drawn = self.random.random_range(0..edge - 1);
            at[axis] = end.map_or(drawn, |place| place.min(edge - 2));
            fraction[axis] = match self.random.random_range(0..5) {
                0 => 0,
                1 => 4096,
                2 => 2048,
                _ => self.random.random_range(0..=4096),
            };
        }
        let bits = self.config.gu.weight_bits;
        let mut entry = RitEntry {
            slot: 0,
            rows: [0; 8],
            weights: [0; 8],
        };
        let weights = &mut entry.weights;
        match vertices {
            Vertices::One => {}
            Vertices::Two => weights[..2].copy_from_slice(&weights::linear(fraction[0], bits)),
            Vertices::Four => {
                let [x, y, _] = fraction;
                weights[..4].copy_from_slice(&weights::bilinear([x, y], bits));
            }
            Vertices::Eight => *weights = weights::trilinear(fraction, bits),
        }
        for v in 0..vertices.count() {
            let place = [0, 1, 2].map(|axis| at[axis] + (v >> axis & 1));
            entry.rows[v] = (place[0] + edges[0] * (place[1] + edges[1] * place[2])) as u16;
        }
        entry
    }
}
