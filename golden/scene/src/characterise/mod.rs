//! The paper's motivation figures, counted on the accesses of a frame rendered in pixel-centric
//! order (Sec. "Motivation", "DRAM Access Inefficiency" and "SRAM Access Inefficiency").
//!
//! The unit of counting is a whole feature vector: of a vertex or of a Gaussian. Rays, or the
//! tiles of splats, run side by side in *lanes*: in every round each unfinished lane reads its
//! next vector.

mod accesses;
mod banks;
mod fields;
mod full_size;
mod oracle;
mod splat_pairs;
mod splat_traffic;
mod splats;
mod stages;
mod tables;
mod traffic;

use schemars::JsonSchema;
use serde::Serialize;

pub use accesses::{Accesses, Vectors};
pub use banks::{BANKS, Banks, LANES};
pub use fields::field_accesses;
pub use full_size::FullSize;
pub use splat_pairs::{SplatPairs, splat_pairs};
pub use splat_traffic::splat_traffic;
pub use splats::splat_accesses;
pub use stages::{Stages, field_stages, splat_stages};
pub use tables::{colour_traffic, sized_traffic, table_traffic};
pub use traffic::{Traffic, traffic};

/// Statistics of an on-chip buffer with oracle replacement.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Memory {
    /// Number of reads.
    pub reads: u64,
    /// Bytes read.
    pub read_bytes: u64,
    /// Number of 32-byte sectors read; every read begins a new one.
    pub sectors: u64,
    /// Number of reads that miss the buffer.
    pub misses: u64,
    /// Bytes of the misses.
    pub bytes: u64,
    /// Misses whose vector does not follow that of the miss before in memory.
    pub not_streaming: u64,
}

impl Memory {
    /// Ratio of misses to reads.
    #[must_use]
    pub fn miss_rate(&self) -> f64 {
        ratio(self.misses, self.reads)
    }

    /// Ratio of non-streaming accesses to all accesses to memory.
    #[must_use]
    pub fn not_streaming_rate(&self) -> f64 {
        ratio(self.not_streaming, self.misses)
    }
}

fn ratio(part: u64, whole: u64) -> f64 {
    part as f64 / whole.max(1) as f64
}
