//! Sparse radiance warping (SpaRW): target frames are warped from a reference
//! frame, and only pixels that it does not show are rendered (paper, "Sparse
//! Radiance Warping").
//!
//! [`reproject`] is the paper's first three steps, [`Warper`] all four for one
//! target; [`Plan`] says which reference serves which targets of a camera path,
//! and [`predict`] from where a reference is taken that is rendered before its
//! targets are known. What renders is a [`Renderer`], and where surfaces are may
//! be told by a [`Geometry`] of its own.
//!
//! # Example
//!
//! A wall two units ahead, seen again from the same place and from one aside.
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
mod run;
mod sample;
mod sampling;
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
pub use run::{Chain, Frame, Sequence};
pub use sampling::Sampling;
pub use target::{Target, Warper};

use glam::DVec3;

use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;

/// Pixels with less opacity than this show nothing: half a step of an 8-bit
/// picture.
pub const VOID_BELOW: f64 = 1.0 / 510.0;

/// A picture and how far away what it shows is.
#[derive(Debug, Clone, PartialEq)]
pub struct Shaded {
    /// The picture, background included.
    pub picture: Picture,
    /// Depth of each pixel along the camera's axis; infinite where nothing is
    /// (void), 0 or not a number where it is not known.
    pub depth: Vec<f32>,
}

/// What renders frames.
pub trait Renderer: Sync {
    /// Linear RGB behind everything.
    fn background(&self) -> [f32; 3];

    /// Corners of a box outside which nothing is, where known.
    fn bounds(&self) -> Option<[DVec3; 2]>;

    /// What a camera sees; of a mask its pixels alone, the others being
    /// background and void.
    ///
    /// # Errors
    /// A camera that cannot be rendered.
    fn shade(&self, camera: &Camera, only: Option<&Mask>) -> Result<Shaded, WarpError>;
}

/// What tells where surfaces are, at little cost.
pub trait Geometry: Sync {
    /// Depth of each pixel along the camera's axis, as in [`Shaded::depth`].
    ///
    /// # Errors
    /// A camera of which it is not known.
    fn depth(&self, camera: &Camera) -> Result<Vec<f32>, WarpError>;
}

/// Whether a depth is that of a surface: positive and finite.
#[must_use]
pub fn is_surface(depth: f32) -> bool {
    depth > 0.0 && depth.is_finite()
}

/// Whether a depth says that nothing is there.
#[must_use]
pub fn is_void(depth: f32) -> bool {
    depth == f32::INFINITY
}
