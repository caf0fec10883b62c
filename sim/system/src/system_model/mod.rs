//! The system around the units: memory, buffers, GPU and link, and the time and energy of a frame
//! or path on them.

mod areas;
mod at_bounds;
mod block_periods;
mod blocks;
mod buffers;
mod chrome_trace;
mod clock;
mod compose;
mod costs;
mod demand;
pub mod dram;
mod error;
#[cfg(test)]
mod figures;
mod frame_jobs;
mod gathering;
mod given;
mod gpu;
mod gpu_only;
mod gpu_work;
pub mod job_scheduler;
mod kernels;
mod logic;
mod memory;
mod memory_costs;
mod memory_device;
mod on_chip_memories;
mod on_chip_sizes;
mod outcome;
mod parts;
mod ranges;
mod spent;
mod splat_costs;
mod system;
#[cfg(test)]
mod tests;
mod transfers;
mod unit_source;
mod variant;
pub mod work;

pub use areas::{Area, BlockArea};
pub use at_bounds::AtBounds;
pub use block_periods::BlockPeriod;
pub use chrome_trace::chrome_trace;
pub use clock::{Clock, ClockOrigin};
pub use costs::{CostError, Costs, MacEnergy, OnChip, Parameters, Unknown};
pub use demand::Demand;
pub use error::ModelError;
pub use gathering::{Gathered, MemorySaving};
pub use gpu::Gpu;
pub use gpu_only::{Alone, GpuOnly, gpu_only};
pub use gpu_work::GpuWork;
pub use kernels::Program;
pub use memory::{Memory, Rate};
pub use memory_device::{FIGURES as MEMORY_FIGURES, MemoryDevice};
pub use on_chip_memories::Port;
pub use on_chip_sizes::OnChipSizes;
pub use outcome::{Model, Outcome, Run, Timeline};
pub use parts::{EnergyByPart, LastThrough, StageTime};
pub use spent::{GpuDone, Spent};
pub use system::{System, SystemError};
pub use variant::{Frames, Gathering, Scenario, Variant};
