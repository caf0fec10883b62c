//! What an analytic scene is made of.

use glam::DVec3;

use super::Look;
use potamoi_fields::voxels::Layout;

/// Optical depth a voxel edge far outside a surface, before the ReLU.
pub(super) const OUTSIDE: f64 = -4.0;
/// The same deep inside.
pub(super) const INSIDE: f64 = 7.9;
/// How fast it rises through the surface, a voxel edge.
const RISE: f64 = 3.0;
/// Steps a voxel edge through surfaces.
const FINE: f64 = 8.0;

/// A radiance field that is known at every point.
pub(super) trait Field: Sync {
    /// Where it is, how finely it is sampled, and from where it is seen.
    fn frame(&self) -> &'static Frame;

    /// Density and emptiness at a point of the bounds.
    fn probe(&self, p: DVec3) -> Probe;

    /// What a point looks like; asked of points of positive density, and of
    /// those within two voxels of one.
    fn look(&self, p: DVec3) -> Look;
}

/// A field at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Probe {
    /// Optical depth a unit of length, before a ReLU.
    pub(super) density: f64,
    /// No point nearer than this has a positive density.
    pub(super) clearance: f64,
    /// A step that sums the density well here.
    pub(super) step: f64,
}

impl Probe {
    /// A solid at a signed distance: a density that rises linearly through the
    /// surface, which a grid of `voxel` interpolates well. `bound` is at most
    /// the true distance.
    pub(super) fn solid(distance: f64, bound: f64, voxel: f64) -> Self {
        let depth = (-RISE * distance / voxel).clamp(OUTSIDE, INSIDE);
        Self {
            density: depth / voxel,
            clearance: bound.max(0.0),
            step: voxel / FINE,
        }
    }

    /// With a smooth density too: the larger of both, in steps of half a voxel
    /// away from the solid.
    pub(super) fn with_haze(self, density: f64, voxel: f64) -> Self {
        if density <= 0.0 {
            return self;
        }
        let apart = self.clearance - voxel;
        Self {
            density: self.density.max(density),
            clearance: 0.0,
            step: apart.clamp(self.step, 0.5 * voxel),
        }
    }
}

/// A camera's way through a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Motion {
    /// Around the target, in degrees a second.
    Orbit(f64),
    /// About the place where it stands, in degrees a second.
    Pan(f64),
}

/// Where a scene is and from where it is seen; z points up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Frame {
    pub(super) name: &'static str,
    /// What it asks of a renderer.
    pub(super) asks: &'static str,
    /// Vertices along x, y, z of the grid that is baked from it.
    pub(super) points: [usize; 3],
    pub(super) corner: DVec3,
    pub(super) voxel: f64,
    pub(super) layout: Layout,
    /// Linear RGB behind everything.
    pub(super) background: [f32; 3],
    pub(super) eye: DVec3,
    pub(super) target: DVec3,
    /// Of the smaller side, in degrees.
    pub(super) fov: f64,
    pub(super) motion: Motion,
}

impl Frame {
    /// Corners of the box outside which nothing is.
    pub(super) fn bounds(&self) -> [DVec3; 2] {
        let size = DVec3::from(self.points.map(|p| (p - 1) as f64)) * self.voxel;
        [self.corner, self.corner + size]
    }
}

/// A colour in steps of 1/4096, which the hardware's accumulators hold exactly.
pub(super) const fn colour(r: u16, g: u16, b: u16) -> [f32; 3] {
    [r as f32 / 4096.0, g as f32 / 4096.0, b as f32 / 4096.0]
}
