//! Ray marching in the memory-centric order.

pub mod streams;
pub mod tiling;
pub mod voxels;
