//! How far a field in the hardware's formats may be from floating point, derived.
//!
//! What is known of a sample before it is rendered, where it lies and which weights that place
//! gives, is computed; every rounding behind it is taken as the worst that it may be: of codes,
//! of gathered features, of each layer's weights and sums, of each result of the vector unit.

mod gathered;
mod off;
mod perceptron;
mod pixel;
#[cfg(test)]
mod tests;
mod units;

use glam::DVec3;
use potamoi_formats::config::{Config, ExpForm};
use rayon::prelude::*;

use super::march::{Samples, check};
use super::{Field, FieldError, FixedOptions};
use crate::voxels::Ray;
use potamoi_base::camera::Camera;
use potamoi_reference::bounds::VectorBounds;

pub(crate) use gathered::gathered;
pub use off::Off;
pub(super) use perceptron::{Outputs, Pair};
pub(super) use units::UnitErrors;

/// What opacity and colour of a field's samples may be off by, in the formats of a configuration.
pub trait Bounds: Sync {
    /// Fraction bits of the codes of each table, channel by channel.
    fn frac_bits(&self) -> &[Vec<u32>];

    /// By how much the opacity may be off at features that are off by so much.
    fn alpha(&self, features: &[f64], off: &[Off]) -> f64;

    /// The same of the colour towards a direction: the most of a channel.
    fn colour(&self, features: &[f64], off: &[Off], direction: DVec3) -> f64;

    /// The ray of a pixel as the hardware's renderer follows it, in vertices of the only table,
    /// where it is not the float one's.
    fn ray(&self, _: [u32; 2]) -> Option<Ray> {
        None
    }

    /// Whether a place of such a ray may be anything.
    fn holds(&self, _: DVec3) -> bool {
        true
    }
}

/// What each pixel's channels may be off by at most beside [`render_float`](super::render_float),
/// row after row; nothing of fields for which none is derived, or where the exponential is of a
/// form whose logistic functions have no bound.
///
/// The picture is affine in each opacity: replacing one of them, those before it replaced already,
/// moves it by the light that reaches the sample times the difference, times at most 1 or the
/// background. A colour moves it by the sample's weight. A sample that may be left out in one of
/// the two pictures alone counts as if it were, and where rays may stop at different samples they
/// differ by what is left there.
///
/// # Errors
/// A field or a camera that does not fit.
pub fn error_bounds(
    field: &dyn Field,
    config: &Config,
    vector: &VectorBounds,
    camera: &Camera,
    options: &FixedOptions,
) -> Result<Option<Vec<f64>>, FieldError> {
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
