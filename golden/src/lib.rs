//! Golden renderers, unit twins and traces: the oracle that the generated
//! hardware is proven equal to.
//!
//! Nothing here knows the netlist. What both sides must agree on (formats,
//! layouts, the configuration) lives in `potamoi-formats`.

pub mod analysis;
pub mod analytic;
pub mod bands;
pub mod camera;
pub mod characterise;
pub mod compact;
pub mod content;
pub mod effects;
pub mod fields;
pub mod files;
#[cfg(test)]
mod hard_cases;
pub mod mask;
pub mod memory;
pub mod mesh;
pub mod picture;
pub mod ply;
pub mod precision;
pub mod record;
pub mod scene;
pub mod sh;
pub mod splats;
pub mod ssim;
pub mod streams;
mod tiling;
pub mod torch;
pub mod trace;
pub mod units;
pub mod voxels;
pub mod warp;
