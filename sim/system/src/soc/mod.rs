//! The system around the units: memory, the array that computes features, and what a frame
//! takes of them.

mod alone;
mod blocks;
mod buffers;
mod compose;
mod costs;
pub mod dram;
pub mod engine;
#[cfg(test)]
mod figures;
mod gathering;
mod gpu;
mod kernels;
mod logic;
mod memory;
mod moves;
pub mod npu;
mod outcome;
mod ranges;
mod system;
#[cfg(test)]
mod tests;
mod variant;
mod walk;
pub mod work;

pub use alone::{AloneTime, alone};
pub use compose::{GpuDone, Spent};
pub use costs::{CostError, Costs, MacEnergy, OnChip, Port};
pub use gathering::{Gathered, MemorySaving};
pub use gpu::Gpu;
pub use kernels::{Instructions, Kernel, Program};
pub use memory::{Memory, Rate};
pub use outcome::{
    EnergyByPart, LastThrough, Model, ModelError, Outcome, Run, StageTime, Timeline,
};
pub use system::{System, SystemError};
pub use variant::{Frames, Gathering, Scenario, Variant};
