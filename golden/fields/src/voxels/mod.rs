//! Voxel grids, and the renderer of all fields in one volume of vertices.
//!
//! A [`Grid`] of vertex features is rendered in 64-bit floating point, pixel by pixel
//! ([`render_float`]), or in fixed point through the units, MVoxel by MVoxel ([`render_fixed`]). A
//! [`Volume`] of another field is rendered the same way.

mod bound;
mod field;
mod fixed;
mod float;
mod formats;
mod grid;
mod mvoxels;
mod ray;
mod schedule;
mod shading;
mod split_halo;
#[cfg(test)]
mod tests;
mod traffic;

pub use bound::{error_bounds, opacity_off};
pub use field::{ALGORITHM, STOP_BELOW, StoredField};
pub use fixed::{
    FixedOptions, Volume, render_fixed, render_volume, render_volume_masked, stops, stored, tasks,
};
pub use float::{FloatOptions, render_float, render_masked};
pub use formats::Formats;
pub use grid::{Grid, Layout, MAX_POINTS, MAX_VALUES};
pub use mvoxels::{MVoxels, Mask};
pub(crate) use ray::Rays;
pub use ray::{Placement, Ray};
pub use schedule::Skip;
pub use shading::Stored;
pub use traffic::traffic;
