//! Tasks at the limits of the tables: rows at and past the end of full MVoxels in both halves, every end
//! of a row of the RIT buffer, ends without bytes, and entries that raise a flag but have a defined result.

use potamoi_formats::config::{Config, EntryKind, Organisation};
use potamoi_formats::rit::{RitEntry, Vertices};
use potamoi_reference::GatherTask;
use rand::Rng;

use super::gather_tasks::Draw;

/// A job of tasks that need not keep all promises.
pub(super) struct Edge {
    /// What is special about it.
    pub(super) what: &'static str,
    pub(super) tasks: Vec<GatherTask>,
    /// Whether beats without bytes end the MVoxels, where these end with a full beat.
    pub(super) null: bool,
    /// Cycles in which the sink takes nothing.
    pub(super) closed: u32,
}

/// Cycles after which a unit with a closed sink stands still, whatever its tables load.
const CLOSED: u32 = 1500;

impl Edge {
    pub(super) const fn plain(tasks: Vec<GatherTask>) -> Self {
        Self::of("", tasks)
    }

    /// The same job, with a sink that is closed for so many cycles.
    fn again(&self, closed: u32) -> Self {
        Self {
            what: if closed > 0 {
                "a sink that is closed for long"
            } else {
                self.what
            },
            tasks: self.tasks.clone(),
            null: self.null,
            closed,
        }
    }

    const fn of(what: &'static str, tasks: Vec<GatherTask>) -> Self {
        Self {
            what,
            tasks,
            null: false,
            closed: 0,
        }
    }
}

/// The jobs, which begin with an idle unit.
pub(super) fn jobs(config: &Config, seed: u64) -> Vec<Edge> {
    let mut draw = Draw::new(config, seed);
    let mut jobs = far(&mut draw);
    for vertices in config.supported_vertices() {
        jobs.extend(ends(&mut draw, vertices));
    }
    let listed = |v: &Vertices| !is_cell(config, *v);
    let built = config.supported_vertices();
    for vertices in built.iter().copied().filter(listed) {
        let words = words(&mut draw, vertices);
        let closed = words.again(CLOSED);
        jobs.extend([words, closed]);
    }
    let weighted = built.iter().copied().filter(listed);
    let weighted: Vec<_> = weighted.filter(|v| v.is_structured()).collect();
    if let Some(vertices) = weighted.iter().min_by_key(|v| v.count()) {
        jobs.push(ties(&mut draw, *vertices));
        jobs.extend(weights(&mut draw, *vertices));
    }
    if let Some(vertices) = weighted.iter().max_by_key(|v| v.count()) {
        jobs.extend(carries(&mut draw, *vertices));
    }
    if built.contains(&Vertices::One) {
        let mut task = small(&mut draw, Vertices::One, 2);
        task.entries[0].rows[0] = loaded(&task) as u16;
        jobs.push(Edge::of("a row past those loaded", vec![task]));
    }
    jobs
}

/// Whether entries are cells of the MVoxel's grid, whose rows the unit computes.
fn is_cell(config: &Config, vertices: Vertices) -> bool {
    vertices.is_structured() && (config.is_parity() || config.rit.entry == EntryKind::Compact)
}

fn loaded(task: &GatherTask) -> usize {
    task.rows.len() / task.channels
}

/// A whole segment; a few channels where each is a beat of its own.
fn channels(draw: &mut Draw<'_>) -> usize {
    match draw.config.organisation().0 {
        Organisation::FeatureMajor => draw.config.gu.banks.min(2) as usize,
        _ => draw.channels(1, true),
    }
}

/// A task of few entries and rows, of one segment.
fn small(draw: &mut Draw<'_>, vertices: Vertices, entries: usize) -> GatherTask {
    let channels = channels(draw);
    draw.task(vertices, channels, 2, entries)
}

/// Full MVoxels, each in both halves of the MFT. The jobs use the same rows: one row too many, all rows,
/// and all but the first.
fn far(draw: &mut Draw<'_>) -> Vec<Edge> {
    let config = draw.config;
    let vertices = config.supported_vertices()[0];
    let rows = config.mvoxel.rows as usize;
    let channels = draw.channels(1, true);
    let mut full = draw.task(vertices, channels, rows, 4 * config.gu.ports as usize + 1);
    if is_cell(config, vertices) {
        let full = Edge::of("all rows", vec![full]);
        return vec![full.again(0), full.again(0), full.again(CLOSED)];
    }
    full.entries = far_entries(draw, vertices, rows);
    let mut jobs = vec![];
    let more = (0..channels).map(|_| draw.feature()).collect();
    let extra = GatherTask {
        rows: [more, full.rows.clone()].concat(),
        ..full.clone()
    };
    let mut fewer = full.clone();
    fewer.rows.drain(..channels);
    let lanes = config.organisation().0 == Organisation::FeatureMajor;
    // Elsewhere the table has no such beats, or the model of the cycles no such rows.
    let reuses = !lanes && config.table_parts() == 1 && loaded(&full) == rows;
    if reuses {
        jobs.push(Edge::of("a row too many", vec![extra]));
    }
    let full = Edge::of("all rows", vec![full]);
    jobs.extend([full.again(0), full.again(0), full.again(CLOSED)]);
    for _ in (0..2).filter(|_| reuses) {
        jobs.push(Edge::of("all rows but one", vec![fewer.clone()]));
    }
    jobs
}

/// Entries that read the first and last rows, those around every power of two, and those past the end.
fn far_entries(draw: &mut Draw<'_>, vertices: Vertices, rows: usize) -> Vec<RitEntry> {
    let powers = (0..16).flat_map(|bit| [1usize << bit, (1 << bit) - 1]);
    let ends = [rows - 2, rows - 1, rows, rows + 1, 2 * rows - 1, 0xffff];
    let mut far: Vec<_> = powers.chain(ends).map(|row| row as u16).collect();
    far.dedup();
    far.extend((0..8).map(|_| draw.random.random_range(0..rows) as u16));
    let entry = |rows: &[u16], draw: &mut Draw<'_>| {
        let mut entry = draw.scattered(vertices, 1, None);
        entry.rows[..rows.len()].copy_from_slice(rows);
        entry.slot = draw.random.random_range(0..=0xffff);
        entry
    };
    far.chunks(vertices.count())
        .map(|rows| entry(rows, draw))
        .collect()
}

/// MVoxels that end in every group of a row of the RIT buffer, with full beats and groups or without; and
/// MVoxels that end with a beat without bytes.
fn ends(draw: &mut Draw<'_>, vertices: Vertices) -> Vec<Edge> {
    let config = draw.config;
    let side = config.gu.ports as usize;
    let entry = config.entry_bytes(vertices);
    let groups = 48 / entry.min(48);
    let channels = channels(draw);
    let of = |count: usize, draw: &mut Draw<'_>| draw.task(vertices, channels, 2, count);
    let partial = (0..=groups).map(|group| group * side + 1 + group % side);
    let tasks = partial.map(|count| of(count, draw)).collect();
    let every = Edge::of("every end of a row of the buffer", tasks);
    let beat = config.rit_stream_bits() as usize / 8;
    let whole = (1..=groups * side).filter(|count| (count * entry).is_multiple_of(beat));
    let whole: Vec<_> = whole.take(6).collect();
    let tasks: Vec<_> = whole.into_iter().map(|count| of(count, draw)).collect();
    let null = Edge {
        null: true,
        ..Edge::of("delayed and ended by beats without bytes", tasks)
    };
    let some = !null.tasks.is_empty();
    [every].into_iter().chain(some.then_some(null)).collect()
}

/// Entries of any bits: rows that are loaded and others, weights that sum to anything.
fn words(draw: &mut Draw<'_>, vertices: Vertices) -> Edge {
    let mut task = small(draw, vertices, 12);
    let rows = loaded(&task) as u16;
    for entry in &mut task.entries {
        for (row, weight) in entry.rows.iter_mut().zip(&mut entry.weights) {
            *row = match draw.random.random_range(0..4) {
                0 => draw.random.random(),
                // One bit too many.
                1 => draw.random.random_range(0..rows) | 1 << draw.random.random_range(2..16),
                _ => draw.random.random_range(0..rows),
            };
            *weight = draw.random.random();
        }
    }
    Edge::of("entries of any bits", vec![task])
}

/// Sums of a half and one bit below it, of either sign, which each decide the rounding alone; and one that
/// rounds past the largest feature.
fn ties(draw: &mut Draw<'_>, vertices: Vertices) -> Edge {
    let gu = &draw.config.gu;
    let (half, one) = (1u16 << (gu.weight_bits - 1), 1u16 << gu.weight_bits);
    let top = (1i32 << (gu.feature_bits - 1)) - 1;
    let below = gu.weight_bits - 1;
    let mut task = small(draw, vertices, 1);
    let rows = [1, -1, 0, top as i16];
    let codes = rows.iter().flat_map(|code| vec![*code; task.channels]);
    task.rows = codes.collect();
    let entry = |terms: [(u16, u16); 2]| {
        let mut entry = task.entries[0];
        (entry.rows, entry.weights) = ([2; 8], [0; 8]);
        for (v, (row, weight)) in terms.into_iter().enumerate() {
            (entry.rows[v], entry.weights[v]) = (row, weight);
        }
        entry
    };
    let bits = (0..below).map(|bit| 1u16 << bit).chain([0]);
    let signs = bits.flat_map(|bit| [(0, bit), (1, bit)]);
    let ties = signs.map(|(row, bit)| entry([(row, half + bit), (2, half - bit)]));
    task.entries = ties
        .chain([entry([(3, one), (0, half + half / 2)])])
        .collect();
    Edge::of("sums that one bit rounds", vec![task])
}

/// Single entries whose weights miss the sum of 1 by one bit, each in a job of its own, and whose weights
/// have a bit too many; a right entry follows, which leaves the flag up.
fn weights(draw: &mut Draw<'_>, vertices: Vertices) -> Vec<Edge> {
    let bits = draw.config.gu.weight_bits;
    let one = 1u16 << bits;
    let task = small(draw, vertices, 2);
    let mut all: Vec<_> = (0..=bits).map(|bit| vec![one - (1 << bit)]).collect();
    all.extend((0..=bits).map(|bit| vec![one, 1 << bit]));
    all.extend((bits + 1..16).map(|bit| vec![one | 1 << bit]));
    all.into_iter().map(|own| weighing(&task, &own)).collect()
}

/// Single entries whose weights would sum to 1 if a carry were lost.
fn carries(draw: &mut Draw<'_>, vertices: Vertices) -> Vec<Edge> {
    let bits = draw.config.gu.weight_bits;
    let largest = (2u32 << bits) - 1;
    let task = small(draw, vertices, 2);
    let sums = (bits + 1..bits + 4).map(|bit| (1 << bits) + (1 << bit));
    let fitting = sums.filter(|sum| *sum <= vertices.count() as u32 * largest);
    let weights = fitting.map(|sum| {
        let whole = std::iter::repeat_n(largest as u16, (sum / largest) as usize);
        let rest = (sum % largest) as u16;
        whole.chain((rest > 0).then_some(rest)).collect::<Vec<_>>()
    });
    weights.map(|own| weighing(&task, &own)).collect()
}

/// A task whose first entry has these weights.
fn weighing(task: &GatherTask, weights: &[u16]) -> Edge {
    let mut task = task.clone();
    task.entries[0].weights = [0; 8];
    task.entries[0].weights[..weights.len()].copy_from_slice(weights);
    Edge::of("weights that are not right", vec![task])
}
