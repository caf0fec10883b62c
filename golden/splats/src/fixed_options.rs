//! Options of the fixed-point renderer.

use potamoi_march::streams::UnitStreams;

use super::reorder_buffer::Order;
use super::schedule::ScheduleOptions;
use super::view::Work;
use super::widths::Widths;

/// The unit that composites.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CompositingUnit {
    /// The vector unit: square sums, exponentials and products of all live pixels of a tile.
    VectorUnit,
    /// The splat unit: a ray group is a job. Pixels outside a mask are composited, too, and dropped.
    SplatUnit,
}

/// Options of the fixed-point renderer.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedOptions {
    /// MVoxels and ray groups.
    pub schedule: ScheduleOptions,
    /// The order in which records are composited.
    pub order: Order,
    /// Capacity of the on-chip reorder buffer in records; more records spill.
    pub hold_records: usize,
    /// Reads of the ray index table.
    pub unit_streams: UnitStreams,
    /// Background, linear RGB, rounded to U4.12.
    pub background: [f32; 3],
    /// The unit that composites.
    pub unit: CompositingUnit,
    /// Whether to keep [`FixedFrame::decisions`]. They are known in exact order and of the vector unit
    /// only: the splat unit returns pixels.
    pub log_decisions: bool,
    /// Fraction bits of the exponential unit.
    pub widths: Widths,
    /// Optional parts of the work.
    pub work: Work,
}

impl Default for FixedOptions {
    fn default() -> Self {
        Self {
            schedule: ScheduleOptions::default(),
            order: Order::Exact,
            hold_records: 8192,
            unit_streams: UnitStreams::default(),
            background: [0.0; 3],
            unit: CompositingUnit::VectorUnit,
            log_decisions: false,
            widths: Widths::PAPER,
            work: Work::ALL,
        }
    }
}
