//! The paper's motivation figures, counted on the accesses of a frame rendered
//! in pixel-centric order (Sec. "Motivation", "DRAM Access Inefficiency" and
//! "SRAM Access Inefficiency").
//!
//! What is counted is feature vectors, whole ones: of a vertex, or of a
//! Gaussian. Rays, or the tiles of splats, go on side by side in *lanes*: in
//! every round each lane that is not done reads its next vector.

mod accesses;
mod banks;
mod fields;
mod full_size;
mod oracle;
mod splat_traffic;
mod splats;
mod stages;
mod tables;
mod traffic;

use serde::Serialize;

pub use accesses::{Accesses, Vectors};
pub use banks::{BANKS, Banks, LANES};
pub use fields::field_accesses;
pub use full_size::FullSize;
pub use splat_traffic::splat_traffic;
pub use splats::splat_accesses;
pub use stages::{Stages, field_stages, splat_stages};
pub use tables::{colour_traffic, sized_traffic, table_traffic};
pub use traffic::{Traffic, traffic};

/// What an on-chip buffer with oracle replacement lets through to memory.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct Memory {
    /// Reads of the buffer.
    pub reads: u64,
    /// Their bytes.
    pub read_bytes: u64,
    /// Their parts of 32 bytes, each read beginning a new one.
    pub sectors: u64,
    /// Reads that it could not serve.
    pub misses: u64,
    /// The bytes of these.
    pub bytes: u64,
    /// Of those reads, vectors that do not lie behind the one before in memory.
    pub not_streaming: u64,
}

impl Memory {
    /// Misses over reads.
    #[must_use]
    pub fn miss_rate(&self) -> f64 {
        ratio(self.misses, self.reads)
    }

    /// Accesses to memory that do not stream, over all of them.
    #[must_use]
    pub fn not_streaming_rate(&self) -> f64 {
        ratio(self.not_streaming, self.misses)
    }
}

fn ratio(part: u64, whole: u64) -> f64 {
    part as f64 / whole.max(1) as f64
}
