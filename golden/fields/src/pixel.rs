//! A pixel of a field's picture in floating point, before the background.

use glam::DVec3;

/// A pixel, with its counts.
#[derive(Clone, Copy)]
pub(super) struct Pixel {
    pub(super) colour: DVec3,
    pub(super) left: f64,
    /// Sum of weights, and sum of weights times distances along the ray.
    pub(super) weight: f64,
    pub(super) moment: f64,
    pub(super) samples: u64,
    pub(super) gathered: u64,
    pub(super) coloured: u64,
}

impl Pixel {
    /// A pixel whose ray meets nothing.
    pub(super) const CLEAR: Self = Self {
        colour: DVec3::ZERO,
        left: 1.0,
        weight: 0.0,
        moment: 0.0,
        samples: 0,
        gathered: 0,
        coloured: 0,
    };

    /// The weighted mean distance along the ray.
    pub(super) fn distance(&self) -> f64 {
        if self.weight > 0.0 {
            self.moment / self.weight
        } else {
            f64::INFINITY
        }
    }
}
