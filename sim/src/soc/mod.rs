//! The system around the units: memory, the array that computes features, and what a frame
//! takes of them.

pub mod dram;
pub mod engine;
pub mod npu;
