//! Error bounds of fixed-point pictures of a field against floating-point ones.
//!
//! The position of a sample and the weights that follow from it are known before rendering, so
//! their effect is computed. All later roundings are taken at their worst: of codes, gathered
//! features, weights and sums of each layer, and results of the vector unit.

mod error_interval;
mod gathered;
mod perceptron;
mod pixel;
#[cfg(test)]
mod tests;
mod units;

use glam::DVec3;
use potamoi_formats::config::{Config, ExpForm};
use rayon::prelude::*;

use super::float::check;
use super::{Field, FieldError, FixedOptions};
use crate::samples::Samples;
use crate::volume::Ray;
use potamoi_base::camera::Camera;
use potamoi_reference::bounds::VectorBounds;

pub use error_interval::ErrorInterval;
pub(crate) use gathered::gathered;
pub(super) use perceptron::{Outputs, Pair};
pub(super) use units::UnitErrors;

/// Error bounds of opacity and colour of a field's samples, for a configuration.
pub trait Bounds: Sync {
    /// Fraction bits of the codes of each table, channel by channel.
    fn frac_bits(&self) -> &[Vec<u32>];

    /// Upper bound of the opacity's error for features with errors `off`.
    fn alpha(&self, features: &[f64], off: &[ErrorInterval]) -> f64;

    /// Upper bound of the colour's error, the largest of a channel, seen along a direction.
    fn colour(&self, features: &[f64], off: &[ErrorInterval], direction: DVec3) -> f64;

    /// The ray of a pixel in the fixed-point renderer, in vertices of the only table, if it
    /// differs from the floating-point ray.
    fn ray(&self, _: [u32; 2]) -> Option<Ray> {
        None
    }

    /// Whether the field may be non-empty at a position on such a ray.
    fn holds(&self, _: DVec3) -> bool {
        true
    }
}

/// Upper bounds of the error of each pixel's channels against
/// [`render_float`](super::render_float), row after row. `None` if the field has no bounds, or if
/// the form of the exponential has none for its logistic functions.
///
/// The picture is affine in each opacity. Replacing one opacity, with those before it replaced
/// already, changes the picture by the transmittance in front of the sample, times the difference,
/// times at most 1 or the background. A colour changes it by the sample's weight. A sample that
/// only one of the pictures may skip counts as skipped in it. If rays may stop at different
/// samples, the remaining transmittance counts.
///
/// # Errors
/// The field or the camera is invalid.
pub fn error_bounds(
    field: &dyn Field,
    config: &Config,
    vector: &VectorBounds,
    camera: &Camera,
    options: &FixedOptions,
) -> Result<Option<Vec<f64>>, FieldError> {
    if let Some(stored) = field.stored() {
        let stop = field.sampling().stop;
        let bounds = stored.pixel_bounds(config, vector, camera, options, stop)?;
        return Ok(Some(bounds));
    }
    if config.vu.exp.form != ExpForm::Restoring {
        return Ok(None);
    }
    let Some(bounds) = field.bounds(config, vector, camera)? else {
        return Ok(None);
    };
    let sampling = field.sampling();
    check(camera, &sampling)?;
    let follower = pixel::Follower {
        field,
        bounds: &*bounds,
        sampling,
        errors: UnitErrors::of(config, vector),
        weight_bits: config.gu.weight_bits,
        options,
    };
    let (width, height) = (camera.width, camera.height);
    let all = (0..width * height).into_par_iter().map(|i| {
        let pixel = [i % width, i / width];
        let ray = Samples::of(&follower.sampling, camera, pixel);
        follower.bound(&ray, bounds.ray(pixel))
    });
    Ok(Some(all.collect()))
}
