//! Ray marching through the units in the memory-centric order: the core that every ray-marched
//! field shares.
//!
//! [`render`] is the only path from rays to pixels. It cuts a picture into ray groups
//! ([`groups`]), gathers the samples of a group batch by batch ([`RayGroup`]) in the order of the
//! field ([`GatherOrder`]), shades them ([`Head`]) and composites them ([`Compositor`]). [`tiling`]
//! cuts vertices into MVoxels, and [`streams`] counts the memory traffic.
//!
//! # Example
//!
//! A grid of 64 vertices an axis is cut into MVoxels of 512 rows, with 8 vertices an axis. The last
//! vertices of an MVoxel are also the first of the next. Each sample belongs to one MVoxel, and has
//! a position in it with 12 fraction bits.
//!
//! ```
//! use potamoi_march::tiling::{Halo, Tiling, edges};
//!
//! let points = [64; 3];
//! let edge = edges(points, 512).unwrap();
//! assert_eq!(edge, [8; 3]);
//! let tiling = Tiling::new(points, edge, Halo::Shared);
//! assert_eq!((tiling.stride(), tiling.count()), ([7; 3], 9 * 9 * 9));
//!
//! let place = tiling.locate([10.25, 0.0, 63.0]);
//! assert_eq!(tiling.index(place.mvoxel), [1, 0, 8]);
//! assert_eq!((place.local, place.fraction), ([3, 0, 6], [1 << 10, 0, 1 << 12]));
//! ```

mod compositor;
mod counts;
mod error;
mod frame;
mod gather;
mod groups;
mod render;
mod sample_outcomes;
mod setup;
mod shading;
mod span;
pub mod streams;
pub mod tiling;
mod transmittance;
mod work;

pub use compositor::{ColourScale, Compositor, pixel_bits};
pub use counts::{FixedStats, Orders};
pub use error::MarchError;
pub use frame::{BACKGROUND, FixedFrame, check_background, place};
pub use gather::gather;
pub use groups::{GROUP_RAYS, default_group_side, groups};
pub use render::{Batch, GatherOrder, Next, RayGroup, render};
pub use sample_outcomes::SampleOutcomes;
pub use setup::Setup;
pub use shading::{Head, Lanes, Opacities, OpacityAlone, Transparent, TruncatedDirections};
pub use span::Span;
pub use transmittance::TRANSMITTANCE;
pub use work::Work;
