//! Splat scenes: loading, projection and rendering of 3D Gaussians.
//!
//! A [`Cloud`] of Gaussians is rendered in 64-bit floating point
//! ([`render_float`]) or through the units in their own formats
//! ([`render_fixed`]). Both start from the same [`View`]: the projected
//! Gaussians in depth order and the tiles that each covers.

mod array;
mod axes;
mod bound;
mod cloud;
mod composite;
mod coverage;
mod depth;
mod error;
mod exponential;
pub mod files;
mod fixed;
mod float;
mod footprint;
mod frame;
mod loaded;
mod octree;
mod partition;
pub mod ply;
mod profile;
pub mod project;
mod records;
mod reorder_buffer;
mod schedule;
mod tile;
mod transmittance;
mod view;

pub use axes::{Axes, UnknownAxes};
pub use bound::{Pair, error_bounds};
pub use cloud::{Cloud, CloudError, Field};
pub use composite::Limits;
pub use composite::Widths;
pub use error::RenderError;
pub use fixed::{FixedFrame, FixedOptions, FixedStats, render_fixed, render_fixed_masked};
pub use float::render_view;
pub use float::{FloatFrame, FloatOptions, FloatStats, render_float, render_masked};
pub use footprint::Footprint;
pub use frame::{Decisions, Flips};
pub use loaded::{Loaded, Raw};
pub use octree::Octree;
pub use partition::{Cells, Partition};
pub use profile::{Extent, Profile, Rules, UnknownProfile};
pub use project::Projected;
pub use project::{rotation, sigmoid};
pub use records::{Saturations, record};
pub use reorder_buffer::Hold;
pub use reorder_buffer::{HoldStats, Order};
pub use schedule::{Group, Load, MVoxel, Schedule, ScheduleOptions, tasks};
pub use transmittance::TRANSMITTANCE;
pub use view::{Sorting, TILE, View, Work, is_any_in_view, is_in_order};
