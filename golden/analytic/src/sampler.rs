//! What a model of an analytic scene is sampled from.

use glam::DVec3;

use super::appearance::Appearance;
use super::bake;
use super::field::{Field, INSIDE};

/// Samples of a scene, also around its bounds: what a model that is no grid is made of.
///
/// ```
/// use potamoi_analytic::Analytic;
///
/// let sampler = Analytic::Cairn.sampler();
/// let middle = sampler.corner() + sampler.voxel() * 0.5 * glam::DVec3::ONE;
/// assert!(sampler.depth(middle) <= 0.0, "the corner of the box is empty");
/// ```
#[derive(Clone, Copy)]
pub struct Sampler(pub(super) &'static dyn Field);

impl Sampler {
    /// Numbers of vertices of the sampled grid along x, y and z.
    #[must_use]
    pub fn points(self) -> [usize; 3] {
        self.0.frame().points
    }

    /// The low corner of the box that contains the scene, in world coordinates.
    #[must_use]
    pub fn corner(self) -> DVec3 {
        self.0.frame().corner
    }

    /// Edge of a voxel of the sampled grid, in world units.
    #[must_use]
    pub fn voxel(self) -> f64 {
        self.0.frame().voxel
    }

    /// Optical depth of a voxel's edge at the density of a world point; at most 0 in empty space.
    #[must_use]
    pub fn depth(self, p: DVec3) -> f64 {
        self.0.probe(p).density * self.voxel()
    }

    /// Whether no light gets as deep as where a voxel's edge has this optical depth.
    #[must_use]
    pub fn is_dark(self, depth: f64) -> bool {
        depth >= INSIDE
    }

    /// The appearance of a world point whose optical depth is above 0.
    #[must_use]
    pub fn look(self, p: DVec3) -> Appearance {
        self.0.look(p)
    }

    /// Evenly distributed viewing directions, to fit what depends on them.
    #[must_use]
    pub fn directions(self) -> impl ExactSizeIterator<Item = DVec3> {
        bake::directions().into_iter()
    }
}
