//! Voxel-grid scenes: baking, MVoxels and rendering.
//!
//! A [`Grid`] of vertex features is rendered in 64-bit floating point, pixel by
//! pixel ([`render_float`]), or through the units in their own formats, MVoxel
//! by MVoxel ([`render_fixed`]).

mod bound;
mod composite;
mod counts;
mod error;
mod fixed;
mod float;
mod formats;
mod grid;
mod head;
mod moved;
mod mvoxels;
mod ray;
mod schedule;
mod split;
#[cfg(test)]
mod tests;

pub use crate::tiling::{Halo, Holder, Place};
pub use bound::{error_bounds, opacity_off};
pub use composite::{Compositor, Work, pixel_bits};
pub use counts::{FixedStats, Orders};
pub use error::VoxelError;
pub use fixed::{BACKGROUND, check_background, gather, place, stored};
pub use fixed::{
    FixedFrame, FixedOptions, Volume, render_fixed, render_volume, render_volume_masked, stops,
    tasks,
};
pub use float::{FloatFrame, FloatOptions, STOP_BELOW, render_float, render_masked};
pub use formats::{Formats, TRANSMITTANCE};
pub use grid::{Grid, Layout, MAX_POINTS, MAX_VALUES};
pub use head::{Facing, OpacityAlone};
pub use head::{Head, Lanes, Opacities};
pub use moved::moved;
pub use mvoxels::{MVoxels, Mask};
pub use ray::Rays;
pub use ray::{Placement, Ray};
pub use schedule::Span;
pub use schedule::{GROUP_RAYS, Skip, default_group_side};
