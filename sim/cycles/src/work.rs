//! Work of a gathering unit, and the beats that carry it.

use potamoi_formats::config::{Config, Organisation, rules};
use potamoi_formats::rit::Vertices;
use thiserror::Error;

/// The size of one MVoxel's work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Mvoxel {
    /// RIT entries, 1 and up.
    pub entries: u32,
    /// Rows loaded into the MFT for each segment, 1 to [`Config::mft_rows`].
    pub rows: u32,
}

/// MVoxels that follow one another with the same settings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct GatherRun<'a> {
    /// Vertices of every entry.
    pub vertices: Vertices,
    /// Channel segments of every MVoxel.
    pub segments: u32,
    /// The MVoxels, in order.
    pub mvoxels: &'a [Mvoxel],
}

/// Why a unit cannot do, or did not do, some work.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum WorkError {
    /// The configuration breaks a rule of hardware generation.
    #[error("the configuration cannot be modelled: {0}")]
    Config(String),
    /// An entry size that the unit is not built for.
    #[error(
        "entries of {vertices} vertices: expected {built}, for which the unit is built; change \
         gu.modes or gu.vertices"
    )]
    Vertices {
        /// Vertices requested.
        vertices: usize,
        /// Sizes that are built.
        built: String,
    },
    /// The number of segments is out of range.
    #[error("{segments} segments: expected 1 to gu.segments = {most}")]
    Segments {
        /// Segments requested.
        segments: u32,
        /// Largest number built.
        most: u32,
    },
    /// An MVoxel has no entries.
    #[error("MVoxel {index} has no entries: leave it out")]
    NoEntries {
        /// Its index in the list.
        index: usize,
    },
    /// An MVoxel has no rows, or more than the MFT holds.
    #[error(
        "MVoxel {index} loads {rows} rows: expected 1 to the {most} of an MFT half (mvoxel.rows)"
    )]
    Rows {
        /// Its index in the list.
        index: usize,
        /// Rows requested.
        rows: u32,
        /// Rows of an MFT half.
        most: u32,
    },
    /// The model is of another organisation.
    #[error(
        "gu.organisation is {found:?}, but this model is of {expected:?}; \
         take the model of the configuration's organisation"
    )]
    Organisation {
        /// Organisation in the configuration.
        found: Organisation,
        /// Organisation of the model.
        expected: Organisation,
    },
    /// MVoxels and rounds of the run contradict each other.
    #[error("MVoxel {index}: {problem}")]
    Rounds {
        /// Its index in the list.
        index: usize,
        /// The problem, and what was expected.
        problem: String,
    },
    /// Ports take turns, but the run has no turns.
    #[error(
        "gu.extra_ports is \"split\": cycles depend on the rows of the entries; \
         give their turns, or take \"copies\""
    )]
    Turns,
    /// Under this stall pattern a stream never moves.
    #[error(
        "stalls of {per_mille} per mille and {burst} cycles: expected 0 to 999, and 1 cycle or more"
    )]
    Stalls {
        /// Probability that a stall begins, in 1/1000.
        per_mille: u16,
        /// Its length in cycles.
        burst: u16,
    },
    /// Deadlock: all streams are willing and nothing moves.
    #[error("deadlock in cycle {cycle}: no unit makes progress although every stream is ready")]
    Deadlock {
        /// The cycle.
        cycle: u64,
    },
}

/// Checks that a unit of `config` can be set to `vertices` and `segments`.
pub(super) fn check_setting(
    config: &Config,
    vertices: Vertices,
    segments: u32,
) -> Result<(), WorkError> {
    let breaches = rules::check(config);
    if !breaches.is_empty() {
        return Err(WorkError::Config(breaches.to_string()));
    }
    let built = config.supported_vertices();
    if !built.contains(&vertices) {
        let built: Vec<_> = built.iter().map(|v| v.count().to_string()).collect();
        return Err(WorkError::Vertices {
            vertices: vertices.count(),
            built: built.join(", "),
        });
    }
    if !(1..=config.gu.segments).contains(&segments) {
        return Err(WorkError::Segments {
            segments,
            most: config.gu.segments,
        });
    }
    Ok(())
}

/// Checks that `config` has the organisation whose cycles do not depend on rows.
pub(super) fn check_channel_major(config: &Config) -> Result<(), WorkError> {
    match config.organisation().0 {
        Organisation::FeatureMajor => Err(WorkError::Organisation {
            found: Organisation::FeatureMajor,
            expected: Organisation::ChannelMajor,
        }),
        _ => Ok(()),
    }
}

/// One beat of the RIT stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RitBeat {
    /// Valid halfwords, from the lowest; 0 on a beat that only marks an end.
    pub halfwords: u32,
    /// `tlast`: last beat of the MVoxel.
    pub last: bool,
    /// `tuser`: the MVoxel exceeds both halves and is streamed again for every segment.
    pub again: bool,
}

/// A beat of the RIT stream, with its position in the work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RitPiece {
    /// Index of the MVoxel.
    pub mvoxel: usize,
    /// First byte of the MVoxel's packed entries.
    pub byte: u64,
    /// Its handshake payload: bytes, last and user.
    pub beat: RitBeat,
}

/// A row on the MFT stream, with its position in the work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MftPiece {
    /// Index of the MVoxel.
    pub mvoxel: usize,
    /// Segment.
    pub segment: u32,
    /// Row.
    pub row: u32,
    /// Whether it is the last row of the MVoxel and segment.
    pub last: bool,
}

impl<'a> GatherRun<'a> {
    /// Checks that a unit of `config` can do this work.
    ///
    /// # Errors
    /// Names the problem: configuration, settings or an MVoxel.
    pub fn check(&self, config: &Config) -> Result<(), WorkError> {
        check_setting(config, self.vertices, self.segments)?;
        let most = config.mft_rows();
        for (index, m) in self.mvoxels.iter().enumerate() {
            if m.entries == 0 {
                return Err(WorkError::NoEntries { index });
            }
            if !(1..=most).contains(&m.rows) {
                let rows = m.rows;
                return Err(WorkError::Rows { index, rows, most });
            }
        }
        Ok(())
    }

    /// Whether an MVoxel's entries exceed both RIT halves, so that they are streamed again for
    /// every segment.
    #[must_use]
    pub(crate) fn streamed_again(&self, config: &Config, mvoxel: Mvoxel) -> bool {
        u64::from(mvoxel.entries) > 2 * u64::from(config.rit_entries(self.vertices))
    }

    /// Cycles to issue one segment of an MVoxel: `ceil(entries / M) V`, or without V where all
    /// vertices are read at once.
    #[must_use]
    pub fn issue_cycles(&self, config: &Config, mvoxel: Mvoxel) -> u64 {
        u64::from(mvoxel.entries.div_ceil(config.gu.ports))
            * u64::from(config.issue_cycles(self.vertices))
    }

    /// Busy cycles of the whole run.
    #[must_use]
    pub fn busy(&self, config: &Config) -> u64 {
        let one: u64 = self
            .mvoxels
            .iter()
            .map(|&m| self.issue_cycles(config, m))
            .sum();
        one * u64::from(self.segments)
    }

    /// Beats of the RIT stream, in order.
    pub fn rit_beats(&self, config: &Config) -> impl Iterator<Item = RitPiece> + use<'a> {
        let run = *self;
        let beat = u64::from(config.rit_stream_bits() / 8);
        let entry = config.entry_bytes(run.vertices) as u64;
        let both = 2 * u64::from(config.rit_entries(run.vertices));
        run.mvoxels.iter().enumerate().flat_map(move |(mvoxel, m)| {
            let again = u64::from(m.entries) > both;
            let bytes = u64::from(m.entries) * entry;
            let beats = bytes.div_ceil(beat);
            let times = if again { run.segments } else { 1 };
            (0..times).flat_map(move |_| {
                (0..beats).map(move |i| RitPiece {
                    mvoxel,
                    byte: i * beat,
                    beat: RitBeat {
                        halfwords: ((bytes - i * beat).min(beat) / 2) as u32,
                        last: i + 1 == beats,
                        again,
                    },
                })
            })
        })
    }

    /// Rows of the MFT stream, in order.
    pub(crate) fn mft_beats(&self) -> impl Iterator<Item = MftPiece> + use<'a> {
        let run = *self;
        run.mvoxels.iter().enumerate().flat_map(move |(mvoxel, m)| {
            (0..run.segments).flat_map(move |segment| {
                (0..m.rows).map(move |row| MftPiece {
                    mvoxel,
                    segment,
                    row,
                    last: row + 1 == m.rows,
                })
            })
        })
    }
}
