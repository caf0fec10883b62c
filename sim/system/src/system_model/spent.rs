//! Bytes, energy and work of jobs.

use potamoi_cycles::batch::Batch;
use schemars::JsonSchema;
use serde::Serialize;

use super::costs::OnChip;

/// Bytes and energy of jobs.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
pub struct Spent {
    /// Bytes read sequentially from memory.
    pub streamed_bytes: f64,
    /// Bytes written sequentially.
    pub written_bytes: f64,
    /// Bytes read at random.
    pub random_bytes: f64,
    /// Transfers of the DMA; the GPU moves its bytes itself.
    pub transfers: u64,
    /// Bytes of DMA descriptors, read at random.
    pub descriptor_bytes: f64,
    /// Bytes of weights, among those read sequentially.
    pub weight_bytes: f64,
    /// Rows of memory opened.
    pub rows_opened: f64,
    /// Work of the device's GPU.
    pub gpu: GpuDone,
    /// Energy of memory accesses without descriptors, in picojoules.
    pub memory_pj: f64,
    /// Energy of reading descriptors, in picojoules.
    pub descriptor_pj: f64,
    /// The part of memory's data lines in both, in picojoules.
    pub memory_io_pj: f64,
    /// Bytes over the interconnect: all of the above, in whole bursts.
    pub interconnect_bytes: f64,
    /// Bytes read from and written to the global feature buffer.
    pub feature_buffer_bytes: f64,
    /// Bytes read from and written to the weight buffer.
    pub weight_buffer_bytes: f64,
    /// Bytes over the link.
    pub link_bytes: f64,
    /// Energy on chip.
    pub on_chip: OnChip,
    /// Work of the units.
    pub done: Batch,
}

/// Work of a GPU.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
pub struct GpuDone {
    /// Operations launched.
    pub launches: f64,
    /// Instructions of all warps.
    pub instructions: f64,
    /// Lines of 128 bytes that requests touch in the first-level cache, and passes over shared
    /// memory; those that wait for a bank count again for each wait.
    pub l1_lines: f64,
    /// Bytes through the second-level cache.
    pub l2_bytes: f64,
    /// Bytes of memory: cache misses and writes.
    pub memory_bytes: f64,
}
