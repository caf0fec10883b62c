//! Samples along a ray.

use glam::DVec3;

use super::{Along, CoordinateFrame, Field, FieldError, Sampling};
use potamoi_base::camera::{Camera, crossing};

/// Maximum number of samples on a ray.
const MAX_SAMPLES: f64 = 1e6;

impl Sampling {
    /// Checks that the samples of a ray can be counted.
    ///
    /// # Errors
    /// The box and the step allow more than a million samples on a ray.
    pub fn check(&self) -> Result<(), FieldError> {
        let [low, high] = self.bounds;
        let size = (high - low).length();
        if size.is_finite() && self.step > 0.0 && size / self.step < MAX_SAMPLES {
            return Ok(());
        }
        Err(FieldError::Part {
            part: "sampling",
            found: format!("steps of {} through {size}", self.step),
            expected: "at most a million samples a ray".to_owned(),
        })
    }
}

/// Samples of a ray.
#[derive(Debug, Clone, Copy)]
pub(super) struct Samples {
    origin: DVec3,
    /// Unit vector.
    pub(super) direction: DVec3,
    near: f64,
    step: f64,
    pub(super) count: u64,
}

impl Samples {
    /// The samples on the ray through the centre of a pixel, in world coordinates.
    pub(super) fn of(sampling: &Sampling, camera: &Camera, pixel: [u32; 2]) -> Self {
        Self::within(sampling, camera, CoordinateFrame::WORLD, pixel)
    }

    pub(super) fn within(
        sampling: &Sampling,
        camera: &Camera,
        frame: CoordinateFrame,
        [x, y]: [u32; 2],
    ) -> Self {
        let (origin, direction) = camera.ray(x, y);
        let origin = (origin - frame.corner) / frame.edge;
        let axis = camera.axis();
        // A step along the ray over one as the range is measured.
        let slant = match sampling.along {
            Along::Axis => 1.0 / axis.dot(direction),
            Along::Ray => 1.0,
        };
        let range = sampling.range.map(|depth| depth * slant);
        let [near, far] = crossing(sampling.bounds, origin, direction, range);
        // Not a number is not at least another.
        let count = if far >= near {
            ((far - near) / sampling.step).min(MAX_SAMPLES) as u64 + 1
        } else {
            0
        };
        Self {
            origin,
            direction,
            near,
            step: sampling.step,
            count,
        }
    }

    /// Distance of sample `k` along the ray.
    pub(super) fn distance(&self, k: u64) -> f64 {
        self.near + self.step * k as f64
    }

    /// World position of sample `k`.
    pub(super) fn at(&self, k: u64) -> DVec3 {
        self.between(k, 0.0)
    }

    /// The first sample from `from` on where the field may be non-empty.
    pub(super) fn next_held(&self, field: &dyn Field, from: u64) -> Option<u64> {
        // Far above what rounding moves a position.
        let slack = 1e-12 * (self.origin.abs().max_element() + self.distance(self.count));
        let mut k = from;
        while k < self.count {
            let Some(empty) = field.empty_for(self.at(k), self.direction) else {
                return Some(k);
            };
            k = k.saturating_add(1 + ((empty - slack) / self.step) as u64);
        }
        None
    }

    /// World position a fraction of a step behind sample `k`.
    pub(super) fn between(&self, k: u64, part: f64) -> DVec3 {
        self.origin + self.direction * (self.near + self.step * (k as f64 + part))
    }
}
