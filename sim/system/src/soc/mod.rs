//! The system on a chip: memory, the MAC array, buffers, GPU and link, and the time and energy of a
//! frame or path on them.

mod blocks;
mod buffers;
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
pub mod npu;
mod outcome;
mod ranges;
mod system;
#[cfg(test)]
mod tests;
mod timeline;
mod transfers;
mod variant;
pub mod work;

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
pub use timeline::chrome_trace;
pub use variant::{Frames, Gathering, Scenario, Variant};
