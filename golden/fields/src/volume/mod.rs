//! A field in one volume of vertices: its MVoxels, and the order in which rays visit them.
//!
//! MVoxels are visited by their distance from the camera's ([`MVoxels::distances`]), each once a ray group.
//! A ray meets them front to back, so it stops at exactly the same sample as on its own, and
//! nothing is gathered behind the MVoxels in which it stops.

mod mask;
mod mvoxels;
mod order;
mod ray;
mod schedule;
mod shared_halo;
mod split_halo;
mod traffic;

use potamoi_march::tiling::Halo;

pub(crate) use mask::Blocks;
pub use mask::Mask;
pub use mvoxels::MVoxels;
pub(crate) use order::MVoxelOrder;
pub(crate) use ray::Rays;
pub use ray::{Placement, Ray};
pub use traffic::traffic;

/// A quantised volume of vertices.
#[derive(Debug, Clone)]
pub struct CodedVolume {
    /// Its MVoxels.
    pub mvoxels: MVoxels,
    /// Its position in the world.
    pub placement: Placement,
    /// Step in voxel edges.
    pub step: f64,
}

impl CodedVolume {
    /// The same volume with another halo.
    #[must_use]
    pub fn with_halo(&self, halo: Halo) -> Self {
        Self {
            mvoxels: self.mvoxels.with_halo(halo),
            ..*self
        }
    }
}
