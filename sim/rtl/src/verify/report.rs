//! Counts of a verification.

use std::collections::BTreeSet;

use schemars::JsonSchema;
use serde::Serialize;

use super::GatherReach;

/// Counts for the gathering unit. Cycles are those of runs without external stalls, unless noted.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct GatherReport {
    /// Runs from reset, each without stalls and again with them.
    pub runs: u64,
    /// MVoxels compared.
    pub mvoxels: u64,
    /// MVoxels of the work.
    pub mvoxels_total: u64,
    /// Entries compared: one feature vector each.
    pub samples: u64,
    /// Entries of the work.
    pub samples_total: u64,
    /// Cycles from the first to the last issue, inclusive, by the unit's counters.
    pub cycles: u64,
    /// Cycles from the first to the last issue, by the closed form.
    pub cycles_predicted: u64,
    /// Busy cycles, in which a vertex was issued.
    pub busy: u64,
    /// Stall cycles with the feature FIFO full.
    pub stall_fifo: u64,
    /// Stall cycles without a loaded MVoxel.
    pub stall_mft: u64,
    /// Stall cycles without an entry.
    pub stall_rit: u64,
    /// Cycles in which lanes waited for a bank (feature-major organisation).
    pub stall_bank: u64,
    /// Cycles from the first RIT beat to the first issue, summed over runs.
    pub fill: u64,
    /// The same sum by the closed form.
    pub fill_predicted: u64,
    /// Cycles compared, with and without stalls, in every handshake, counter and feature.
    pub cycles_compared: u64,
    /// Cycles compared under random stalls on every stream.
    pub cycles_stalled: u64,
    /// Stall cycles of all runs, with and without external stalls: FIFO, MFT, RIT, bank.
    pub stalls_compared: [u64; 4],
    /// What the compared entries exercised.
    pub reach: GatherReach,
}

/// Counts for the vector unit.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct VectorReport {
    /// Runs from reset, each without stalls and again with them.
    pub runs: u64,
    /// Operations of compared elements, by name.
    pub operations: BTreeSet<&'static str>,
    /// Elements compared.
    pub elements: u64,
    /// Elements of the work.
    pub elements_total: u64,
    /// Vectors accepted without stalls, by the unit's counter.
    pub vectors: u64,
    /// Cycles from the first vector to the last result, inclusive, without stalls.
    pub cycles: u64,
    /// The same cycles by the closed form.
    pub cycles_predicted: u64,
    /// Cycles in which a vector was accepted or stepped, without stalls.
    pub busy: u64,
    /// Cycles without stalls in which a vector was refused only by back-pressure.
    pub stall_out: u64,
    /// Cycles compared, with and without stalls, in every handshake, counter and result.
    pub cycles_compared: u64,
    /// Cycles compared under random stalls on both streams.
    pub cycles_stalled: u64,
}

/// Counts for the splat unit.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct SplatReport {
    /// Runs from reset, each without stalls and again with them.
    pub runs: u64,
    /// Jobs compared, one a ray group.
    pub jobs: u64,
    /// Jobs of the work.
    pub jobs_total: u64,
    /// Pixels compared, 256 a tile.
    pub pixels: u64,
    /// Pixels of the work.
    pub pixels_total: u64,
    /// Records in tiles, by the unit's counter, without stalls; likewise the next four.
    pub records: u64,
    /// Pairs of pixel and record whose power was computed.
    pub square_sums: u64,
    /// Pairs whose exponential was computed.
    pub exponentials: u64,
    /// Pairs that contributed to a pixel.
    pub drawn: u64,
    /// Pairs that ended a pixel.
    pub stopped: u64,
    /// Cycles from the first beat to the last pixel, without stalls. The cycle model has the same.
    pub cycles: u64,
    /// Cycles in which the unit was not idle, by its counter, without stalls.
    pub busy: u64,
    /// Cycles compared, with and without stalls, in every handshake, counter and pixel.
    pub cycles_compared: u64,
    /// Cycles compared under random stalls on both streams.
    pub cycles_stalled: u64,
}
