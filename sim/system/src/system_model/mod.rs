//! The system around the units: memory, buffers, GPU and link, and the time and energy of a frame
//! or path on them.

mod blocks;
mod buffers;
mod chrome_trace;
mod compose;
mod costs;
pub mod dram;
mod error;
#[cfg(test)]
mod figures;
mod frame_jobs;
mod gathering;
mod gpu;
mod gpu_only;
pub mod job_scheduler;
mod kernels;
mod logic;
mod memory;
mod outcome;
mod ranges;
mod system;
#[cfg(test)]
mod tests;
mod transfers;
mod variant;
pub mod work;

pub use chrome_trace::chrome_trace;
pub use compose::{GpuDone, Spent};
pub use costs::{CostError, Costs, MacEnergy, OnChip, Port};
pub use error::ModelError;
pub use gathering::{Gathered, MemorySaving};
pub use gpu::Gpu;
pub use gpu_only::{GpuOnlyTime, gpu_only};
pub use kernels::{Instructions, Kernel, Program};
pub use memory::{Memory, Rate};
pub use outcome::{EnergyByPart, LastThrough, Model, Outcome, Run, StageTime, Timeline};
pub use system::{System, SystemError};
pub use variant::{Frames, Gathering, Scenario, Variant};
