//! The interface of analytic scenes.

use glam::DVec3;

use super::Appearance;
use potamoi_fields::voxels::Layout;

/// Optical depth a voxel edge far outside a surface, before the ReLU.
pub(super) const OUTSIDE: f64 = -4.0;
/// Optical depth a voxel edge deep inside, before the ReLU.
pub(super) const INSIDE: f64 = 7.9;
/// Slope of the optical depth through the surface, per voxel edge.
const RISE: f64 = 3.0;
/// Number of steps in a voxel edge through surfaces.
const FINE: f64 = 8.0;

/// A radiance field that can be evaluated at every point.
pub(super) trait Field: Sync {
    /// Its position, sampling and camera path.
    fn frame(&self) -> &'static SceneSetup;

    /// Density and distance of emptiness at a point within the bounds.
    fn probe(&self, p: DVec3) -> Probe;

    /// The appearance of a point; called for points of positive density, and for those within two
    /// voxels of one.
    fn look(&self, p: DVec3) -> Appearance;
}

/// Density of a field around a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Probe {
    /// Optical depth per unit of length, before a ReLU.
    pub(super) density: f64,
    /// Radius within which no density is positive.
    pub(super) clearance: f64,
    /// A step length with which sums of density are accurate here.
    pub(super) step: f64,
}

impl Probe {
    /// A solid at a signed distance: the density rises linearly through the surface, which a grid
    /// of edge `voxel` interpolates well. `bound` must be at most the true distance.
    pub(super) fn solid(distance: f64, bound: f64, voxel: f64) -> Self {
        let depth = (-RISE * distance / voxel).clamp(OUTSIDE, INSIDE);
        Self {
            density: depth / voxel,
            clearance: bound.max(0.0),
            step: voxel / FINE,
        }
    }

    /// Adds a smooth density: the larger of both, in steps of half a voxel away from the solid.
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

/// The motion of a camera through a scene.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Motion {
    /// Around the target, in degrees per second.
    Orbit(f64),
    /// Around its own position, in degrees per second.
    Pan(f64),
}

/// Position, sampling and camera path of a scene; z points up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct SceneSetup {
    pub(super) name: &'static str,
    /// Difficulty for a renderer, in a few words.
    pub(super) asks: &'static str,
    /// Number of vertices of the sampled grid along x, y, z.
    pub(super) points: [usize; 3],
    pub(super) corner: DVec3,
    pub(super) voxel: f64,
    pub(super) layout: Layout,
    /// Background, linear RGB.
    pub(super) background: [f32; 3],
    pub(super) eye: DVec3,
    pub(super) target: DVec3,
    /// Field of view of the smaller side, in degrees.
    pub(super) fov: f64,
    pub(super) motion: Motion,
}

impl SceneSetup {
    /// Corners of the box that contains the scene.
    pub(super) fn bounds(&self) -> [DVec3; 2] {
        let size = DVec3::from(self.points.map(|p| (p - 1) as f64)) * self.voxel;
        [self.corner, self.corner + size]
    }
}

/// A colour in steps of 1/4096, which the hardware's accumulators represent exactly.
pub(super) const fn colour(r: u16, g: u16, b: u16) -> [f32; 3] {
    [r as f32 / 4096.0, g as f32 / 4096.0, b as f32 / 4096.0]
}
