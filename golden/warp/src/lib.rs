//! Sparse radiance warping (SpaRW): target frames are warped from a reference frame, and only the
//! pixels that it does not show are rendered (paper, "Sparse Radiance Warping").
//!
//! [`reproject`] implements the paper's first three steps, [`Warper`] all four for one target.
//! [`Plan`] assigns references to the targets of a camera path, and [`predict`] extrapolates the
//! camera of a reference that is rendered before its targets are known. A [`Renderer`] renders
//! frames; a separate [`Geometry`] may supply the depth of surfaces.
//!
//! # Example
//!
//! A wall two units ahead, seen again from the same position and from one to the side.
//!
//! ```
//! use glam::DVec3;
//! use potamoi_base::camera::Camera;
//! use potamoi_base::picture::Picture;
//! use potamoi_warp::{Shaded, reproject};
//!
//! let at = |x: f64| {
//!     let (eye, ahead) = (DVec3::new(x, 0.0, 0.0), DVec3::Z);
//!     Camera::look_at(eye, eye + ahead, DVec3::Y, 0.5, 16, 16)
//! };
//! let wall = Shaded {
//!     picture: Picture { width: 16, height: 16, rgb: vec![[0.5; 3]; 256] },
//!     depth: vec![2.0; 256],
//! };
//! let from = at(0.0);
//! let warped = reproject(&wall, &from, &from);
//! // A camera that stands still sees every pixel where it was.
//! assert!((0..256).all(|pixel| warped.at(pixel).unwrap() == (pixel as u32, 2.0)));
//! // From aside, each pixel shows the point of another, or none at the edge.
//! let beside = reproject(&wall, &from, &at(0.2));
//! assert!((0..256).all(|pixel| beside.at(pixel).is_none_or(|(source, _)| source != pixel as u32)));
//! ```

mod classify;
mod crack;
mod error;
mod half_resolution;
pub mod mesh;
mod pixel;
mod plan;
mod predict;
mod reproject;
mod ridge;
mod sampler;
mod sampling;
mod sequence;
mod silhouette;
mod target;
#[cfg(test)]
mod tests;

pub use classify::subtended;
pub use classify::{Angle, Class, Counts, Profile, Rule, Scope};
pub use error::WarpError;
pub use half_resolution::half_resolution;
pub use plan::{Plan, PlanOptions, ReferenceFrom, ReferenceTask, TargetTask};
pub use predict::predict;
pub use predict::rotation_vector;
pub use reproject::{Warped, reproject};
pub use ridge::{BayesianRidge, Fit};
pub use sampling::Sampling;
pub use sequence::{Chain, Frame, Sequence};
pub use target::{Target, Warper};

use glam::DVec3;

use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;

/// Opacity below which a pixel counts as void: half a step of an 8-bit picture.
pub const VOID_BELOW: f64 = 1.0 / 510.0;

/// A picture with depth.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaded {
    /// The picture, including the background.
    pub picture: Picture,
    /// Depth per pixel along the camera's axis: infinite for void, 0 or NaN if unknown.
    pub depth: Vec<f32>,
}

/// A renderer of frames.
pub trait Renderer: Sync {
    /// Background, linear RGB.
    fn background(&self) -> [f32; 3];

    /// Corners of a box that contains the model, if known.
    fn bounds(&self) -> Option<[DVec3; 2]>;

    /// Renders a camera's view. With a mask, renders only its pixels; the others are background
    /// and void.
    ///
    /// # Errors
    /// The camera cannot be rendered.
    fn shade(&self, camera: &Camera, only: Option<&Mask>) -> Result<Shaded, WarpError>;
}

/// A source of depth that costs little.
pub trait Geometry: Sync {
    /// Depth per pixel along the camera's axis, as in [`Shaded::depth`].
    ///
    /// # Errors
    /// The depth is not known for this camera.
    fn depth(&self, camera: &Camera) -> Result<Vec<f32>, WarpError>;
}

/// Whether a depth is that of a surface: positive and finite.
#[must_use]
pub fn is_surface(depth: f32) -> bool {
    depth > 0.0 && depth.is_finite()
}

/// Whether a depth is void, that is, infinite.
#[must_use]
pub fn is_void(depth: f32) -> bool {
    depth == f32::INFINITY
}
