//! Work and traffic of a frame of the fixed-point renderer.

use std::collections::BTreeMap;

use potamoi_formats::units::OpCode;
use potamoi_march::streams::Streams;
use potamoi_reference::splat_unit::SplatUnitCounts;

use super::records::Saturations;
use super::reorder_buffer::HoldStats;
use super::schedule::PairTest;

/// Work and traffic of a frame.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FixedStats {
    /// Gaussians that touch a tile.
    pub visible: u64,
    /// Feature vectors that the gathering unit returned, one an entry.
    pub gathers: u64,
    /// MVoxels gathered, over all ray groups.
    pub tasks: u64,
    /// Bytes by stream.
    pub streams: Streams,
    /// Bytes of records fetched one by one, a part of the MVoxel bytes.
    pub scattered_bytes: u64,
    /// Elements that the vector unit returned, by operation.
    pub vector_elements: BTreeMap<OpCode, u64>,
    /// Work of the splat unit; zero where the vector unit composites.
    pub splat_unit: SplatUnitCounts,
    /// Exponentials. Of the vector unit one for each (pixel, entry) whose pixel had not stopped, of the
    /// splat unit one for each that its cut keeps.
    pub exponentials: u64,
    /// Affine forms that the MAC array computed for the vector unit, two for each of its exponentials;
    /// each takes two passes of 16-bit multipliers.
    pub affine_forms: u64,
    /// (pixel, entry) pairs whose power was computed: of the vector unit all whose pixel had not
    /// stopped, of the splat unit those in a span.
    pub evaluated: u64,
    /// (pixel, entry) pairs that contributed to a pixel.
    pub drawn: u64,
    /// Pixels that terminated early.
    pub stopped: u64,
    /// Record values that saturated.
    pub saturations: Saturations,
    /// Statistics of the reorder buffer; zero in approximate order.
    pub hold: HoldStats,
    /// (tile, Gaussian) pairs that were tested, and left out; `None` without limits.
    pub pair_test: Option<PairTest>,
    /// Entries that reached their tile after one of a higher rank; zero in exact order.
    pub inversions: u64,
}
