//! Gathering tasks as beats on the unit's streams.

use potamoi_formats::config::Config;
use potamoi_formats::rit::{RitError, Vertices};
use potamoi_golden::units::GatherTask;
use thiserror::Error;

/// A task that the unit cannot take.
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

/// One beat of the RIT stream.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct RitBeat {
    pub(super) data: Vec<u32>,
    pub(super) keep: Vec<u32>,
    pub(super) last: bool,
    pub(super) user: bool,
}

/// One beat of the MFT stream.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct MftBeat {
    pub(super) data: Vec<u32>,
    pub(super) last: bool,
}

/// One beat of features: for every port that holds an entry, its slot and its
/// `B` channels.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FeatureBeat {
    /// Slot and features of each kept port, port 0 first.
    pub entries: Vec<(u32, Vec<i16>)>,
    /// The MVoxel and segment ends.
    pub last: bool,
    /// Cycle in which it was accepted.
    pub cycle: u64,
}

/// Everything that a run sends.
#[derive(Debug, Clone)]
pub struct GatherStreams {
    pub(super) rit: Vec<RitBeat>,
    pub(super) mft: Vec<MftBeat>,
    pub(super) vertices: Vertices,
    pub(super) segments: usize,
    /// Beats of features that will come back.
    pub(super) beats: usize,
    /// Issuing cycles: sum of ceil(entries / M) x V over MVoxels and segments.
    pub(super) issues: u64,
}

impl GatherStreams {
    /// Lays tasks out as streams.
    ///
    /// # Errors
    /// A task that is malformed or differs from the first in kind.
    pub fn new(config: &Config, tasks: &[GatherTask]) -> Result<Self, StreamError> {
        let shape = |task: usize, problem: String| StreamError::Shape { task, problem };
        let first = tasks
            .first()
            .ok_or_else(|| shape(0, "no tasks: expected one at least".to_owned()))?;
        let (vertices, channels) = (first.vertices, first.channels);
        if !config.supported_vertices().contains(&vertices) {
            return Err(shape(
                0,
                format!(
                    "entries of {} vertices: the unit is not built for them",
                    vertices.count()
                ),
            ));
        }
        let segments = config.segments(channels).max(1);
        if segments > config.gu.segments as usize {
            return Err(shape(
                0,
                format!(
                    "{channels} channels take {segments} segments: gu.segments is {}",
                    config.gu.segments
                ),
            ));
        }
        let mut streams = Self {
            rit: vec![],
            mft: vec![],
            vertices,
            segments,
            beats: 0,
            issues: 0,
        };
        for (i, task) in tasks.iter().enumerate() {
            for (same, what) in [
                (task.vertices == vertices, "entry size"),
                (task.channels == channels, "number of channels"),
            ] {
                if !same {
                    return Err(StreamError::Mixed { task: i, what });
                }
            }
            if task.entries.is_empty()
                || channels == 0
                || task.rows.is_empty()
                || !task.rows.len().is_multiple_of(channels)
            {
                let problem = format!(
                    "{} entries, {} codes in rows of {channels}: expected an entry and whole rows",
                    task.entries.len(),
                    task.rows.len()
                );
                return Err(shape(i, problem));
            }
            let rows = task.rows.len() / channels;
            if rows > config.mvoxel.rows as usize {
                return Err(shape(
                    i,
                    format!("{rows} rows: mvoxel.rows is {}", config.mvoxel.rows),
                ));
            }
            streams.entries(config, i, task)?;
            streams.features(config, task);
            let groups = task.entries.len().div_ceil(config.gu.ports as usize);
            streams.beats += groups * segments;
            streams.issues += (groups * vertices.count() * segments) as u64;
        }
        Ok(streams)
    }

    fn entries(
        &mut self,
        config: &Config,
        index: usize,
        task: &GatherTask,
    ) -> Result<(), StreamError> {
        let mut bytes = vec![];
        for entry in &task.entries {
            entry
                .pack(task.vertices, &mut bytes)
                .map_err(|source| StreamError::Entry {
                    task: index,
                    source,
                })?;
        }
        let user = task.entries.len() > 2 * config.rit_entries(task.vertices) as usize;
        let beat = config.rit_stream_bits() as usize / 8;
        let count = bytes.len().div_ceil(beat);
        let passes = if user { self.segments } else { 1 };
        for _ in 0..passes {
            for (i, part) in bytes.chunks(beat).enumerate() {
                self.rit.push(RitBeat {
                    data: words(part, beat),
                    keep: mask(part.len(), beat),
                    last: i + 1 == count,
                    user,
                });
            }
        }
        Ok(())
    }

    fn features(&mut self, config: &Config, task: &GatherTask) {
        let banks = config.gu.banks as usize;
        let count = task.rows.len() / task.channels;
        for segment in 0..self.segments {
            for (i, row) in task.rows.chunks(task.channels).enumerate() {
                let channels = row.iter().skip(segment * banks).take(banks);
                let bytes: Vec<u8> = channels.flat_map(|c| c.to_le_bytes()).collect();
                self.mft.push(MftBeat {
                    data: words(&bytes, 2 * banks),
                    last: i + 1 == count,
                });
            }
        }
    }
}

/// Bytes as 32-bit words, low first, filled up with zeros to `size` bytes.
fn words(bytes: &[u8], size: usize) -> Vec<u32> {
    let mut out = vec![0u32; size.div_ceil(4)];
    for (i, byte) in bytes.iter().enumerate() {
        out[i / 4] |= u32::from(*byte) << (8 * (i % 4));
    }
    out
}

/// `count` low bits of `size`.
fn mask(count: usize, size: usize) -> Vec<u32> {
    let mut out = vec![0u32; size.div_ceil(32)];
    for i in 0..count {
        out[i / 32] |= 1 << (i % 32);
    }
    out
}
