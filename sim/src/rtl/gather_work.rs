//! Gathering tasks as a run of the unit: its sizes, and the words of its beats.

use potamoi_formats::config::{Config, Organisation};
use potamoi_formats::rit::{RitError, Vertices};
use potamoi_golden::units::GatherTask;
use thiserror::Error;

use super::place::{Placed, is_needed};
use super::words::half;
use crate::cycles::rounds::rounds;
use crate::cycles::split::turns;
use crate::cycles::work::{GatherRun, MftPiece, Mvoxel, RitPiece};
use crate::cycles::{LaneRun, Rounds, SplitRun};

/// A task that a run cannot take.
#[derive(Debug, Error)]
pub enum StreamError {
    /// Entries of another size, or another number of channels, in one run.
    #[error("task {task}: {what} differs from the first task's; a run keeps one setting")]
    Mixed {
        /// The task.
        task: usize,
        /// What differs.
        what: &'static str,
    },
    /// A task without entries or with rows that are no whole number of features.
    #[error("task {task}: {problem}")]
    Shape {
        /// The task.
        task: usize,
        /// What is wrong, and what was expected.
        problem: String,
    },
    /// Entries that a unit of cells cannot take.
    #[error("task {task}: {problem}")]
    Place {
        /// The task.
        task: usize,
        /// Why, and what to do.
        problem: String,
    },
    /// A slot that its entry cannot carry.
    #[error("task {task}: {source}")]
    Entry {
        /// The task.
        task: usize,
        /// Why.
        source: RitError,
    },
}

/// Tasks of one kind, one after the other from reset.
#[derive(Debug, Clone)]
pub struct GatherWork<'a> {
    pub(super) tasks: &'a [GatherTask],
    pub(super) vertices: Vertices,
    pub(super) channels: usize,
    pub(super) segments: usize,
    /// Channels that a beat of the MFT stream brings.
    pub(super) banks: usize,
    /// Channels of a full segment.
    segment_channels: usize,
    /// Entries that a beat of features holds, and channels of each.
    pub(super) side: usize,
    pub(super) width: usize,
    pub(super) slot_bits: u32,
    /// Bytes of a channel on the feature stream.
    pub(super) lane_bytes: usize,
    /// Whether two records share a row of the MFT, and the bit of an id that picks
    /// one of them.
    pub(super) shared_rows: Option<u32>,
    beat_bytes: usize,
    /// Vertices of a row of the MFT.
    vertices_a_row: usize,
    mvoxels: Vec<Mvoxel>,
    /// The tasks at fixed places, for a unit that needs them there.
    placed: Vec<Placed>,
    /// Rounds of each MVoxel in the feature-major organisation.
    rounds: Option<Vec<Vec<Rounds>>>,
    /// Turns of each MVoxel where ports take any.
    turns: Option<Vec<Vec<Rounds>>>,
}

impl<'a> GatherWork<'a> {
    /// Checks that tasks can follow one another in one run.
    ///
    /// # Errors
    /// A task that is malformed or differs from the first in kind.
    pub fn new(config: &Config, tasks: &'a [GatherTask]) -> Result<Self, StreamError> {
        let shape = |task: usize, problem: String| StreamError::Shape { task, problem };
        let first = tasks
            .first()
            .ok_or_else(|| shape(0, "no tasks: expected one at least".to_owned()))?;
        let (vertices, channels) = (first.vertices, first.channels);
        let mut mvoxels = Vec::with_capacity(tasks.len());
        let mut placed = vec![];
        let shared = config.records_a_row(vertices, channels) == 2;
        for (i, task) in tasks.iter().enumerate() {
            for (same, what) in [
                (task.vertices == vertices, "entry size"),
                (task.channels == channels, "number of channels"),
            ] {
                if !same {
                    return Err(StreamError::Mixed { task: i, what });
                }
            }
            let codes = task.rows.len();
            if task.entries.is_empty()
                || channels == 0
                || codes == 0
                || !codes.is_multiple_of(channels)
            {
                let entries = task.entries.len();
                let problem = format!(
                    "{entries} entries, {codes} codes in rows of {channels}: expected an entry and whole rows"
                );
                return Err(shape(i, problem));
            }
            let fits = |n: usize, what: &str| {
                u32::try_from(n).map_err(|_| shape(i, format!("{n} {what}: expected below 2^32")))
            };
            let mut rows = codes / channels;
            if shared {
                rows = rows.div_ceil(2);
            }
            if is_needed(config, vertices) {
                let place = Placed::new(config, task);
                let place = place.map_err(|problem| StreamError::Place { task: i, problem })?;
                rows = match config.is_parity() {
                    true => place.blocks(),
                    false => place.full_rows(),
                };
                placed.push(place);
            }
            mvoxels.push(Mvoxel {
                entries: fits(task.entries.len(), "entries")?,
                rows: fits(rows, "rows")?,
            });
        }
        let gu = &config.gu;
        let (side, width, rounds) = match config.organisation().0 {
            Organisation::Auto | Organisation::ChannelMajor | Organisation::Parity => {
                (gu.ports, config.lanes_a_port(), None)
            }
            Organisation::FeatureMajor => {
                let of = |t: &GatherTask| rounds(config, vertices, &t.entries);
                (gu.lanes, 1, Some(tasks.iter().map(of).collect()))
            }
        };
        let turns = (config.table_parts() > 1).then(|| {
            let of = |(i, task): (usize, &GatherTask)| match placed.get(i) {
                Some(placed) => turns(config, vertices, &placed.entries),
                None if shared => {
                    let mut rows = task.entries.clone();
                    rows.iter_mut().for_each(|entry| entry.rows[0] >>= 1);
                    turns(config, vertices, &rows)
                }
                None => turns(config, vertices, &task.entries),
            };
            tasks.iter().enumerate().map(of).collect()
        });
        Ok(Self {
            tasks,
            vertices,
            channels,
            segments: config.segments(channels).max(1),
            banks: gu.banks as usize,
            segment_channels: config.lanes_a_port() as usize,
            side: side as usize,
            width: width as usize,
            slot_bits: config.rit.slot_bits,
            lane_bytes: config.feature_lane_bits() as usize / 8,
            shared_rows: shared.then(|| config.row_bits()),
            beat_bytes: config.rit_stream_bits() as usize / 8,
            vertices_a_row: config.vertices_a_row() as usize,
            mvoxels,
            placed,
            rounds,
            turns,
        })
    }

    /// The run as the feature-major models see it; none in another
    /// organisation.
    #[must_use]
    pub fn lane_run(&self) -> Option<LaneRun<'_>> {
        let rounds = self.rounds.as_deref()?;
        Some(LaneRun {
            run: self.run(),
            channels: self.channels,
            rounds,
        })
    }

    /// The run as the models of ports that take turns see it; none where they do not.
    #[must_use]
    pub fn split_run(&self) -> Option<SplitRun<'_>> {
        Some(SplitRun {
            run: self.run(),
            turns: self.turns.as_deref()?,
        })
    }

    /// The code in a lane of the feature stream.
    pub(super) fn code(&self, words: &[u32], lane: usize) -> i32 {
        if self.lane_bytes == 4 {
            words[lane] as i32
        } else {
            i32::from(half(words, lane) as i16)
        }
    }

    /// The run as the cycle models see it.
    #[must_use]
    pub fn run(&self) -> GatherRun<'_> {
        GatherRun {
            vertices: self.vertices,
            segments: self.segments as u32,
            mvoxels: &self.mvoxels,
        }
    }

    /// Beats of features that come back.
    #[must_use]
    pub fn beats(&self) -> u64 {
        let groups = |t: &GatherTask| t.entries.len().div_ceil(self.side) as u64;
        let parts = |s: usize| self.channels_of(s).len().div_ceil(self.width) as u64;
        let parts: u64 = (0..self.segments).map(parts).sum();
        self.tasks.iter().map(groups).sum::<u64>() * parts
    }

    /// Entries of all tasks.
    #[must_use]
    pub fn entries(&self) -> u64 {
        self.tasks.iter().map(|t| t.entries.len() as u64).sum()
    }

    /// The channels of a segment.
    pub(super) fn channels_of(&self, segment: usize) -> std::ops::Range<usize> {
        let low = segment * self.segment_channels;
        low..self.channels.min(low + self.segment_channels)
    }

    /// Channels of the last segment.
    pub(super) fn last_channels(&self) -> usize {
        self.channels_of(self.segments - 1).len()
    }

    /// The tasks' places, beat by beat of the feature stream.
    pub(super) fn groups(&self) -> impl Iterator<Item = Group> + use<'a> {
        let (tasks, side, width) = (self.tasks, self.side, self.width);
        let segments: Vec<_> = (0..self.segments).map(|s| self.channels_of(s)).collect();
        let mut before = 0;
        tasks.iter().enumerate().flat_map(move |(task, t)| {
            let entries = t.entries.len();
            let first = before;
            before += entries;
            let groups = entries.div_ceil(side);
            let segments = segments.clone().into_iter().enumerate();
            segments.flat_map(move |(segment, channels)| {
                (0..groups).flat_map(move |group| {
                    let (start, end) = (channels.start, channels.end);
                    channels.clone().step_by(width).map(move |low| Group {
                        task,
                        segment,
                        entry: group * side,
                        kept: side.min(entries - group * side),
                        ordinal: first + group * side,
                        low,
                        begins: low == start,
                        last: group + 1 == groups && low + width >= end,
                    })
                })
            })
        })
    }
}

/// One beat of features: where it belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Group {
    pub(super) task: usize,
    pub(super) segment: usize,
    /// First entry, in its task.
    pub(super) entry: usize,
    pub(super) kept: usize,
    /// First entry, among those of all tasks.
    pub(super) ordinal: usize,
    /// Its lowest channel, and whether that is the segment's.
    pub(super) low: usize,
    pub(super) begins: bool,
    /// The last of its MVoxel and segment.
    pub(super) last: bool,
}

/// Lays out beats as the words of the ports.
pub(super) struct Layout<'a> {
    work: &'a GatherWork<'a>,
    /// The packed entries of one task.
    packed: (usize, Vec<u8>),
    pub(super) data: Vec<u32>,
    pub(super) keep: Vec<u32>,
    pub(super) row: Vec<u32>,
    /// Of `row`, where the stream says what is kept.
    pub(super) row_keep: Vec<u32>,
}

impl<'a> Layout<'a> {
    pub(super) fn new(work: &'a GatherWork<'a>) -> Self {
        Self {
            work,
            packed: (usize::MAX, vec![]),
            data: vec![0; work.beat_bytes.div_ceil(4)],
            keep: vec![0; work.beat_bytes.div_ceil(32)],
            row: vec![0; work.banks.div_ceil(2)],
            row_keep: vec![0; work.banks.div_ceil(16)],
        }
    }

    /// Fills `data` and `keep`.
    pub(super) fn rit(&mut self, piece: &RitPiece) -> Result<(), StreamError> {
        if self.packed.0 != piece.mvoxel {
            self.packed.1.clear();
            self.pack(piece.mvoxel)?;
            self.packed.0 = piece.mvoxel;
        }
        let from = piece.byte as usize;
        let count = 2 * piece.beat.halfwords as usize;
        let bytes = &self.packed.1[from..from + count];
        self.data.fill(0);
        for (word, part) in self.data.iter_mut().zip(bytes.chunks(4)) {
            for (i, byte) in part.iter().enumerate() {
                *word |= u32::from(*byte) << (8 * i);
            }
        }
        for (i, word) in self.keep.iter_mut().enumerate() {
            let left = count.saturating_sub(32 * i).min(32);
            *word = ((1u64 << left) - 1) as u32;
        }
        Ok(())
    }

    /// Packs the entries of a task.
    fn pack(&mut self, task: usize) -> Result<(), StreamError> {
        let packed = &mut self.packed.1;
        let placed = self.work.placed.get(task);
        if let Some(placed) = placed.filter(|p| !p.compact.is_empty()) {
            let words = placed.compact.iter().map(|entry| entry.word());
            packed.extend(words.flat_map(u64::to_le_bytes));
            return Ok(());
        }
        let entries = placed.map_or(&self.work.tasks[task].entries, |p| &p.entries);
        for entry in entries {
            let mut entry = *entry;
            if let Some(bit) = self.work.shared_rows {
                let [record, ..] = entry.rows;
                entry.rows[0] = record >> 1 | (record & 1) << bit;
            }
            entry
                .pack(self.work.vertices, packed)
                .map_err(|source| StreamError::Entry { task, source })?;
        }
        Ok(())
    }

    /// Fills `row`, and `row_keep` in the feature-major organisation.
    pub(super) fn mft(&mut self, piece: &MftPiece) {
        if self.work.rounds.is_some() {
            return self.block(piece);
        }
        let work = self.work;
        let row = piece.row as usize;
        self.row.fill(0);
        match work.placed.get(piece.mvoxel) {
            None if work.shared_rows.is_some() => {
                let records = work.tasks[piece.mvoxel].rows.len() / work.channels;
                for (i, first) in [0, work.width / 2].into_iter().enumerate() {
                    let record = Some(2 * row + i).filter(|record| *record < records);
                    self.vertex(piece, first, record);
                }
            }
            None => self.vertex(piece, 0, Some(row)),
            Some(placed) if work.vertices_a_row == 1 => {
                self.vertex(piece, 0, placed.own_row(placed.place_of(row)));
            }
            Some(placed) => {
                for parity in 0..work.vertices_a_row {
                    let place = placed.place_in_block(row, parity);
                    self.vertex(piece, parity * work.width, placed.own_row(place));
                }
            }
        }
    }

    /// One channel of B rows.
    fn block(&mut self, piece: &MftPiece) {
        let (banks, channels) = (self.work.banks, self.work.channels);
        let segment = self.work.channels_of(piece.segment as usize);
        let beat = piece.row as usize;
        let (block, channel) = (beat / segment.len(), segment.start + beat % segment.len());
        let rows = self.work.tasks[piece.mvoxel].rows.chunks_exact(channels);
        self.row.fill(0);
        self.row_keep.fill(0);
        for (b, row) in rows.skip(block * banks).take(banks).enumerate() {
            self.row[b / 2] |= u32::from(row[channel] as u16) << (16 * (b % 2));
            self.row_keep[b / 16] |= 3 << (2 * (b % 16));
        }
    }

    /// Fills the lanes from `first` on with a row of the task, or leaves them 0.
    fn vertex(&mut self, piece: &MftPiece, first: usize, row: Option<usize>) {
        let Some(row) = row else {
            return;
        };
        let (width, channels) = (self.work.width, self.work.channels);
        let low = piece.segment as usize * width;
        let from = row * channels;
        let rows = &self.work.tasks[piece.mvoxel].rows;
        let codes = &rows[from + low..from + channels.min(low + width)];
        for (lane, code) in (first..).zip(codes) {
            self.row[lane / 2] |= u32::from(*code as u16) << (16 * (lane % 2));
        }
    }
}
