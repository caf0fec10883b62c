//! Gathering tasks as one run of the unit: settings, sizes and beats.

use potamoi_formats::config::{Config, Organisation};
use potamoi_formats::rit::{RitError, Vertices};
use potamoi_reference::GatherTask;
use thiserror::Error;

use crate::bank_rounds::rounds;
use crate::row_remap::{RemappedTask, is_needed};
use crate::split_banks::turns;
use crate::work::{GatherRun, Mvoxel};
use crate::{LaneRun, Rounds, SplitRun};

/// Why a run cannot take a task.
#[derive(Debug, Error)]
pub enum StreamError {
    /// Tasks with different entry sizes or channels in one run.
    #[error("task {task}: {what} differs from the first task's; a run keeps one setting")]
    Mixed {
        /// Index of the task.
        task: usize,
        /// The difference.
        what: &'static str,
    },
    /// A task without entries, or whose rows are no whole number of features.
    #[error("task {task}: {problem}")]
    Shape {
        /// Index of the task.
        task: usize,
        /// The problem, and what was expected.
        problem: String,
    },
    /// Entries that a unit of cells cannot take.
    #[error("task {task}: {problem}")]
    Place {
        /// Index of the task.
        task: usize,
        /// The problem and the remedy.
        problem: String,
    },
    /// A slot that its entry cannot carry.
    #[error("task {task}: {source}")]
    Entry {
        /// Index of the task.
        task: usize,
        /// The reason.
        source: RitError,
    },
}

/// Tasks of one kind, in sequence from reset.
#[derive(Debug, Clone)]
pub struct GatherWork<'a> {
    pub(crate) tasks: &'a [GatherTask],
    pub(crate) vertices: Vertices,
    pub(crate) channels: usize,
    pub(crate) segments: usize,
    /// Channels in a beat of the MFT stream.
    pub(crate) banks: usize,
    /// Channels of a full segment.
    segment_channels: usize,
    /// Entries in a beat of features, and channels of each.
    pub(crate) side: usize,
    pub(crate) width: usize,
    pub(crate) slot_bits: u32,
    /// Bytes of a channel on the feature stream.
    pub(crate) lane_bytes: usize,
    /// Whether two records share a row of the MFT, and then the bit of an id that selects one of
    /// them.
    pub(crate) shared_rows: Option<u32>,
    pub(crate) beat_bytes: usize,
    /// Vertices of a row of the MFT.
    pub(crate) vertices_a_row: usize,
    mvoxels: Vec<Mvoxel>,
    /// Tasks remapped to fixed rows, for units that need them.
    pub(crate) placed: Vec<RemappedTask>,
    /// Rounds of each MVoxel in the feature-major organisation.
    pub(crate) rounds: Option<Vec<Vec<Rounds>>>,
    /// Turns of each MVoxel, where ports take turns.
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
                let place = RemappedTask::new(config, task);
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

    /// The run for the feature-major models; `None` in another organisation.
    #[must_use]
    pub fn lane_run(&self) -> Option<LaneRun<'_>> {
        let rounds = self.rounds.as_deref()?;
        Some(LaneRun {
            run: self.run(),
            channels: self.channels,
            rounds,
        })
    }

    /// The run for models of ports that take turns; `None` for other ports.
    #[must_use]
    pub fn split_run(&self) -> Option<SplitRun<'_>> {
        Some(SplitRun {
            run: self.run(),
            turns: self.turns.as_deref()?,
        })
    }

    /// The tasks, in order.
    #[must_use]
    pub const fn tasks(&self) -> &'a [GatherTask] {
        self.tasks
    }

    /// Vertices of every entry.
    #[must_use]
    pub const fn vertices(&self) -> Vertices {
        self.vertices
    }

    /// Channels of a feature.
    #[must_use]
    pub const fn channels(&self) -> usize {
        self.channels
    }

    /// Segments of the channels.
    #[must_use]
    pub const fn segments(&self) -> usize {
        self.segments
    }

    /// Entries in a beat of features.
    #[must_use]
    pub const fn side(&self) -> usize {
        self.side
    }

    /// Channels of each entry in a beat of features.
    #[must_use]
    pub const fn width(&self) -> usize {
        self.width
    }

    /// Bits of a slot.
    #[must_use]
    pub const fn slot_bits(&self) -> u32 {
        self.slot_bits
    }

    /// Bytes of a channel on the feature stream.
    #[must_use]
    pub const fn lane_bytes(&self) -> usize {
        self.lane_bytes
    }

    /// Whether two records share a row of the MFT.
    #[must_use]
    pub const fn shares_rows(&self) -> bool {
        self.shared_rows.is_some()
    }

    /// The run for the cycle models.
    #[must_use]
    pub fn run(&self) -> GatherRun<'_> {
        GatherRun {
            vertices: self.vertices,
            segments: self.segments as u32,
            mvoxels: &self.mvoxels,
        }
    }

    /// Beats of features returned.
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
    #[must_use]
    pub fn channels_of(&self, segment: usize) -> std::ops::Range<usize> {
        let low = segment * self.segment_channels;
        low..self.channels.min(low + self.segment_channels)
    }

    /// Channels of the last segment.
    #[must_use]
    pub fn last_channels(&self) -> usize {
        self.channels_of(self.segments - 1).len()
    }

    /// The groups of the run, one for each beat of the feature stream.
    pub fn groups(&self) -> impl Iterator<Item = Group> + use<'a> {
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

/// Position of one beat of features.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Group {
    /// Index of its task.
    pub task: usize,
    /// Its segment.
    pub segment: usize,
    /// Index of its first entry within the task.
    pub entry: usize,
    /// Entries in it.
    pub kept: usize,
    /// Index of its first entry among those of all tasks.
    pub ordinal: usize,
    /// Its lowest channel.
    pub low: usize,
    /// Whether that is the segment's lowest channel.
    pub begins: bool,
    /// Whether it is the last of its MVoxel and segment.
    pub last: bool,
}

/// Splits tasks into runs: those that can follow one another.
pub fn runs(tasks: &[GatherTask]) -> impl Iterator<Item = &[GatherTask]> {
    tasks.chunk_by(|a, b| (a.vertices, a.channels) == (b.vertices, b.channels))
}
