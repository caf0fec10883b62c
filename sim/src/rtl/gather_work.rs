//! Gathering tasks as a run of the unit: its sizes, and the words of its beats.

use potamoi_formats::config::{Config, Organisation};
use potamoi_formats::rit::{RitError, Vertices};
use potamoi_golden::units::GatherTask;
use thiserror::Error;

use crate::cycles::feature_major::rounds;
use crate::cycles::work::{GatherRun, MftPiece, Mvoxel, RitPiece};
use crate::cycles::{LaneRun, Rounds};

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
    pub(super) banks: usize,
    /// Entries that a beat of features holds, and channels of each.
    pub(super) side: usize,
    pub(super) width: usize,
    pub(super) slot_bits: u32,
    beat_bytes: usize,
    mvoxels: Vec<Mvoxel>,
    /// Rounds of each MVoxel in the feature-major organisation.
    rounds: Option<Vec<Vec<Rounds>>>,
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
            mvoxels.push(Mvoxel {
                entries: fits(task.entries.len(), "entries")?,
                rows: fits(codes / channels, "rows")?,
            });
        }
        let gu = &config.gu;
        let (side, width, rounds) = match gu.organisation {
            Organisation::ChannelMajor => (gu.ports, gu.banks, None),
            Organisation::FeatureMajor => {
                let of = |t: &GatherTask| rounds(config, vertices, &t.entries);
                (gu.lanes, 1, Some(tasks.iter().map(of).collect()))
            }
        };
        Ok(Self {
            tasks,
            vertices,
            channels,
            segments: config.segments(channels).max(1),
            banks: gu.banks as usize,
            side: side as usize,
            width: width as usize,
            slot_bits: config.rit.slot_bits,
            beat_bytes: config.rit_stream_bits() as usize / 8,
            mvoxels,
            rounds,
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
    fn channels_of(&self, segment: usize) -> std::ops::Range<usize> {
        let low = segment * self.banks;
        low..self.channels.min(low + self.banks)
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
            for entry in &self.work.tasks[piece.mvoxel].entries {
                entry
                    .pack(self.work.vertices, &mut self.packed.1)
                    .map_err(|source| StreamError::Entry {
                        task: piece.mvoxel,
                        source,
                    })?;
            }
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

    /// Fills `row`, and `row_keep` in the feature-major organisation.
    pub(super) fn mft(&mut self, piece: &MftPiece) {
        if self.work.rounds.is_some() {
            return self.block(piece);
        }
        let (banks, channels) = (self.work.banks, self.work.channels);
        let low = piece.segment as usize * banks;
        let from = piece.row as usize * channels;
        let rows = &self.work.tasks[piece.mvoxel].rows;
        let codes = &rows[from + low..from + channels.min(low + banks)];
        self.row.fill(0);
        for (word, pair) in self.row.iter_mut().zip(codes.chunks(2)) {
            for (i, code) in pair.iter().enumerate() {
                *word |= u32::from(*code as u16) << (16 * i);
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
}
