//! The feature-major organisation, whose lanes have bank conflicts.
//!
//! Its cycles depend on which rows are read, unlike the channel-major ones.
//! [`rounds`](super::bank_rounds::rounds) counts them from the entries alone, [`FeatureMajorModel`]
//! steps through every cycle, and [`feature_major_cycles`] gives the totals for sources and sink
//! that are always ready. Rules: `docs/explanation/organisations.md`.

mod closed_form;
mod model;

#[cfg(test)]
mod tests;

use potamoi_formats::config::{Config, Organisation};
use potamoi_formats::timing::Pipeline;

use super::bank_rounds::Rounds;
use super::work::{GatherRun, MftPiece, WorkError};

pub use closed_form::feature_major_cycles;
pub use model::FeatureMajorModel;

/// Cycles from the issue of a channel's last round to its offer.
fn latency() -> u64 {
    Pipeline::crossbar().cycles().into()
}

/// A run of MVoxels on the feature-major unit.
#[derive(Debug, Clone, Copy)]
pub struct LaneRun<'a> {
    /// Sizes and settings.
    pub run: GatherRun<'a>,
    /// Channels, summed over segments.
    pub channels: usize,
    /// For each MVoxel, the rounds of each R entries.
    pub rounds: &'a [Vec<Rounds>],
}

impl<'a> LaneRun<'a> {
    /// Checks that a unit of `config` can do this work.
    ///
    /// # Errors
    /// Names the problem.
    pub fn check(&self, config: &Config) -> Result<(), WorkError> {
        self.run.check(config)?;
        if config.gu.organisation != Organisation::FeatureMajor {
            return Err(WorkError::Organisation {
                found: config.gu.organisation,
                expected: Organisation::FeatureMajor,
            });
        }
        let segments = config.segments(self.channels);
        if segments != self.run.segments as usize {
            return Err(WorkError::Rounds {
                index: 0,
                problem: format!(
                    "{} channels are {segments} segments, but the run has {}",
                    self.channels, self.run.segments
                ),
            });
        }
        for (index, mvoxel) in self.run.mvoxels.iter().enumerate() {
            let expected = mvoxel.entries.div_ceil(config.gu.lanes) as usize;
            let found = self.rounds.get(index).map_or(0, Vec::len);
            if found != expected {
                let problem = format!("rounds of {found} groups of lanes: expected {expected}");
                return Err(WorkError::Rounds { index, problem });
            }
        }
        Ok(())
    }

    /// Channels of a segment.
    #[must_use]
    pub fn channels(&self, config: &Config, segment: u32) -> u64 {
        channels_of(self.channels, config.gu.banks, segment)
    }

    /// Beats of the MFT stream for a segment of an MVoxel: one for each channel of B rows.
    #[must_use]
    pub(crate) fn mft_beats(&self, config: &Config, rows: u32, segment: u32) -> u64 {
        beats_of(self.channels, config.gu.banks, rows, segment)
    }

    /// The beats of the MFT stream, in order; `row` is a beat's index within its MVoxel and
    /// segment.
    pub fn mft_pieces(&self, config: &Config) -> impl Iterator<Item = MftPiece> + use<'a> {
        let (run, channels, banks) = (self.run, self.channels, config.gu.banks);
        run.mvoxels.iter().enumerate().flat_map(move |(mvoxel, m)| {
            (0..run.segments).flat_map(move |segment| {
                let beats = beats_of(channels, banks, m.rows, segment) as u32;
                (0..beats).map(move |row| MftPiece {
                    mvoxel,
                    segment,
                    row,
                    last: row + 1 == beats,
                })
            })
        })
    }
}

fn beats_of(channels: usize, banks: u32, rows: u32, segment: u32) -> u64 {
    u64::from(rows.div_ceil(banks)) * channels_of(channels, banks, segment)
}

/// Channels of a segment: B, in the last one the remainder.
fn channels_of(channels: usize, banks: u32, segment: u32) -> u64 {
    let before = u64::from(segment) * u64::from(banks);
    (channels as u64).saturating_sub(before).min(banks.into())
}
