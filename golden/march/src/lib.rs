//! Ray marching through the units, in the memory-centric order: what every field that is
//! marched needs.
//!
//! [`render`] is the one road: a picture is cut into ray groups ([`groups`]), the samples of a
//! group are gathered batch by batch ([`RayGroup`]), shaded ([`Head`]) and composited
//! ([`Compositor`]). [`tiling`] cuts vertices into MVoxels, and [`streams`] counts the bytes that
//! go to and come from memory.

mod compositor;
mod counts;
mod error;
mod frame;
mod gather;
mod groups;
mod render;
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
pub use render::{Batch, Next, RayGroup, Setup, render};
pub use shading::{Facing, Head, Lanes, Opacities, OpacityAlone};
pub use span::Span;
pub use transmittance::TRANSMITTANCE;
pub use work::Work;
