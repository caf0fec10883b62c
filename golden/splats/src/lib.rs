//! Gaussian splatting: projection and rendering of 3D Gaussians.
//!
//! A [`Cloud`](potamoi_gaussians::Cloud) is rendered in 64-bit floating point ([`render_float`]), or in fixed
//! point through the units ([`render_fixed`]). Both start from the same [`View`]: the projected
//! Gaussians in depth order, and the tiles that each covers.
//!
//! ```
//! use glam::DVec3;
//! use potamoi_base::camera::Camera;
//! use potamoi_gaussians::Cloud;
//! use potamoi_splats::{FloatOptions, Profile, render_float};
//!
//! // One Gaussian of half a unit at the origin.
//! let cloud = Cloud::new(
//!     0,
//!     vec![[0.0; 3]],
//!     vec![[0.5f32.ln(); 3]],
//!     vec![[1.0, 0.0, 0.0, 0.0]],
//!     vec![2.0],
//!     vec![[1.0; 3]],
//! )?;
//! let eye = DVec3::new(0.0, 0.0, -3.0);
//! let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.7, 9, 9);
//! let frame = render_float(&cloud, &camera, Profile::Inria, &FloatOptions::default())?;
//! let [middle, corner] = [4 * 9 + 4, 0].map(|i| frame.picture.rgb[i][0]);
//! assert!(middle > corner);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bound;
mod composite;
mod compositing;
mod coverage;
mod decisions;
mod depth;
mod error;
mod fixed;
mod fixed_options;
mod fixed_stats;
mod float;
mod footprint;
mod octree;
mod partition;
mod profile;
mod project;
mod records;
mod reorder_buffer;
mod schedule;
mod tile_test;
mod transmittance;
mod unit_entries;
mod view;
mod widths;

pub use bound::{Pair, error_bounds};
pub use composite::Limits;
pub use decisions::{Decisions, Flips};
pub use error::RenderError;
pub use fixed::{FixedFrame, render_fixed, render_fixed_masked};
pub use fixed_options::{CompositingUnit, FixedOptions};
pub use fixed_stats::FixedStats;
pub use float::render_view;
pub use float::{FloatFrame, FloatOptions, FloatStats, render_float, render_masked};
pub use footprint::Footprint;
pub use octree::Octree;
pub use partition::{Cells, Partition};
pub use profile::{Extent, Profile, Rules, UnknownProfile};
pub use project::Projected;
pub use records::{RecordForm, Saturations, record};
pub use reorder_buffer::Hold;
pub use reorder_buffer::{HoldStats, Order};
pub use schedule::{Group, Load, MVoxel, PairTest, Schedule, ScheduleOptions, tasks};
pub use tile_test::TileLimits;
pub use transmittance::TRANSMITTANCE;
pub use unit_entries::{unit_entries, unit_settings};
pub use view::{Sorting, TILE, View, Work, is_any_in_view, is_in_order};
pub use widths::Widths;
