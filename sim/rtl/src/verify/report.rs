//! What a verification counts.

use serde::Serialize;

/// Of the gathering unit. Cycles are those of runs without stalls from
/// outside, unless said otherwise.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct GatherReport {
    /// Runs from reset, each made without stalls and again with them.
    pub runs: u64,
    /// MVoxels that were compared.
    pub mvoxels: u64,
    /// MVoxels of the work.
    pub mvoxels_total: u64,
    /// Entries that were compared: one feature vector each.
    pub samples: u64,
    /// Entries of the work.
    pub samples_total: u64,
    /// Cycles from first to last issue, both included, by the unit's counters.
    pub cycles: u64,
    /// The same, by the closed form.
    pub cycles_predicted: u64,
    /// Cycles in which a vertex was issued.
    pub busy: u64,
    /// Stalls for want of room in the feature FIFO.
    pub stall_fifo: u64,
    /// Stalls for want of an MVoxel.
    pub stall_mft: u64,
    /// Stalls for want of entries.
    pub stall_rit: u64,
    /// Cycles in which lanes waited for a bank (feature-major organisation).
    pub stall_bank: u64,
    /// Sum over runs of the cycles from first RIT beat to first issue.
    pub fill: u64,
    /// The same, by the closed form.
    pub fill_predicted: u64,
    /// Cycles, with and without stalls, in which every handshake, counter and
    /// feature was compared.
    pub cycles_compared: u64,
    /// Of those, cycles under random stalls on every stream.
    pub cycles_stalled: u64,
}

/// Of the vector unit.
#[derive(Debug, Clone, Default, PartialEq, Eq, Serialize)]
pub struct VectorReport {
    /// Runs from reset, each made without stalls and again with them.
    pub runs: u64,
    /// Elements that were compared.
    pub elements: u64,
    /// Elements of the work.
    pub elements_total: u64,
    /// Vectors accepted by the unit, by its counter, without stalls.
    pub vectors: u64,
    /// Cycles from the first vector to the last result, both included,
    /// without stalls.
    pub cycles: u64,
    /// The same, by the closed form.
    pub cycles_predicted: u64,
    /// Cycles in which a vector was accepted or stepped, without stalls.
    pub busy: u64,
    /// Cycles in which only the lack of room refused a vector, without stalls.
    pub stall_out: u64,
    /// Cycles, with and without stalls, in which every handshake, counter and
    /// result was compared.
    pub cycles_compared: u64,
    /// Of those, cycles under random stalls on both streams.
    pub cycles_stalled: u64,
}
