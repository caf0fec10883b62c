//! The gathering unit's part of the configuration.

use serde::{Deserialize, Serialize};

use super::Config;
use crate::rit::{MAX_VERTICES, Vertices, WORD_BYTES};

/// The macro voxel.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MvoxelConfig {
    /// Rows of the MVoxel feature table: vertices, or records, an MVoxel holds.
    pub rows: u32,
}

impl Default for MvoxelConfig {
    fn default() -> Self {
        Self { rows: 512 }
    }
}

/// The ray index table.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RitConfig {
    /// Eight-vertex entries in one half of the double buffer. A half has 48
    /// times as many bytes; smaller entries fill the same bytes.
    pub entries: u32,
    /// Bits of the RIT stream; 64 a port unless given.
    pub stream_bits: Option<u32>,
    /// Bits of the slot that come back with the features, 16 or 32.
    pub slot_bits: u32,
}

impl Default for RitConfig {
    fn default() -> Self {
        Self {
            entries: 128,
            stream_bits: None,
            slot_bits: 16,
        }
    }
}

/// Which kinds of entry the unit is built for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Modes {
    /// Weighted entries of several vertices only.
    Structured,
    /// Single ids only: no reducers.
    Unstructured,
    /// Both, chosen by `cfg_vertices`.
    Both,
}

/// What may be assumed of an entry's weights.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum WeightTrust {
    /// They sum to exactly 1: the narrow accumulator, and a sticky flag if not.
    Trusted,
    /// Any codes: the accumulator holds eight products of any size.
    Any,
}

/// How features lie in the banks of the MVoxel feature table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Organisation {
    /// Bank `b` holds channel `b` of every row: no two reads meet in a bank.
    #[default]
    ChannelMajor,
    /// A bank holds whole rows, row `r` in bank `r mod B`: concurrent ray
    /// samples meet in banks, and wait for one another.
    FeatureMajor,
}

/// The gathering unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GuConfig {
    /// How features lie in the banks.
    pub organisation: Organisation,
    /// Banks `B`: channels read in one cycle.
    pub banks: u32,
    /// Ports `M`: entries processed side by side.
    pub ports: u32,
    /// Lanes `R` of the feature-major organisation: ray samples processed
    /// side by side.
    pub lanes: u32,
    /// Kinds of entry.
    pub modes: Modes,
    /// Entry sizes of the structured kind that the unit supports.
    pub vertices: Vec<Vertices>,
    /// Bits of a feature code.
    pub feature_bits: u32,
    /// Fraction bits `W` of a weight, U1.W.
    pub weight_bits: u32,
    /// What may be assumed of weights.
    pub weights: WeightTrust,
    /// The most channel segments an MVoxel is gathered in.
    pub segments: u32,
    /// Beats the feature FIFO holds.
    pub fifo_depth: u32,
    /// Bits of the cycle and stall counters, which stop at their maximum.
    pub counter_bits: u32,
}

impl Default for GuConfig {
    fn default() -> Self {
        Self {
            organisation: Organisation::ChannelMajor,
            banks: 32,
            ports: 2,
            lanes: 16,
            modes: Modes::Both,
            vertices: vec![Vertices::Eight, Vertices::Four, Vertices::Two],
            feature_bits: 16,
            weight_bits: 15,
            weights: WeightTrust::Trusted,
            segments: 8,
            fifo_depth: 8,
            counter_bits: 32,
        }
    }
}

impl Config {
    /// Bits of the RIT stream.
    #[must_use]
    pub fn rit_stream_bits(&self) -> u32 {
        self.rit.stream_bits.unwrap_or(64 * self.gu.ports)
    }

    /// Bits of one RIT row: `M` eight-vertex entries.
    #[must_use]
    pub fn rit_row_bits(&self) -> u32 {
        self.gu.ports * (MAX_VERTICES * WORD_BYTES * 8) as u32
    }

    /// Rows of one RIT half.
    #[must_use]
    pub fn rit_rows(&self) -> u32 {
        self.rit.entries / self.gu.ports
    }

    /// Entries that one RIT half holds.
    #[must_use]
    pub fn rit_entries(&self, vertices: Vertices) -> u32 {
        (self.rit.entries as usize * MAX_VERTICES * WORD_BYTES / vertices.entry_bytes()) as u32
    }

    /// Entry sizes that the unit supports, fewest vertices first.
    #[must_use]
    pub fn supported_vertices(&self) -> Vec<Vertices> {
        let gu = &self.gu;
        Vertices::ALL
            .into_iter()
            .filter(|v| match gu.modes {
                Modes::Structured => gu.vertices.contains(v),
                Modes::Unstructured => !v.is_structured(),
                Modes::Both => !v.is_structured() || gu.vertices.contains(v),
            })
            .collect()
    }

    /// Segments that `channels` take: `ceil(channels / B)`.
    #[must_use]
    pub fn segments(&self, channels: usize) -> usize {
        channels.div_ceil(self.gu.banks as usize)
    }

    /// Bits of the reducers' accumulators.
    #[must_use]
    pub fn accumulator_bits(&self) -> u32 {
        let exact = self.gu.feature_bits + self.gu.weight_bits;
        match self.gu.weights {
            WeightTrust::Trusted => exact,
            // Eight codes below 2^(W+1) add four bits.
            WeightTrust::Any => exact + 4,
        }
    }
}
