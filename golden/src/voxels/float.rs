//! The renderer in 64-bit floating point, pixel by pixel.

use glam::DVec3;
use rayon::prelude::*;

use super::error::VoxelError;
use super::grid::Grid;
use super::ray::{Ray, Rays};
use crate::camera::Camera;
use crate::picture::Picture;

/// A ray stops once less than this of the light behind would be seen.
pub const STOP_BELOW: f64 = 1e-3;

/// How to render in floating point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FloatOptions {
    /// Voxel edges from sample to sample.
    pub step: f64,
    /// Whether rays stop at [`STOP_BELOW`].
    pub terminate: bool,
    /// Linear RGB behind everything.
    pub background: [f32; 3],
}

impl Default for FloatOptions {
    fn default() -> Self {
        Self {
            step: 0.5,
            terminate: true,
            background: [0.0; 3],
        }
    }
}

/// A rendered frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FloatFrame {
    /// The picture, background included.
    pub picture: Picture,
    /// Transmittance left at each pixel.
    pub transmittance: Vec<f64>,
    /// Samples interpolated.
    pub samples: u64,
}

/// Renders a grid: `alpha = 1 - exp(-density step)` of the interpolated density
/// after its ReLU, front to back from where a ray enters the volume.
///
/// # Errors
/// A camera or a step that is not sensible.
pub fn render_float(
    grid: &Grid,
    camera: &Camera,
    options: &FloatOptions,
) -> Result<FloatFrame, VoxelError> {
    let rays = Rays::new(grid, camera, options.step)?;
    let [width, height] = rays.size();
    let background = DVec3::from(options.background.map(f64::from));
    let pixels: Vec<(DVec3, f64, u64)> = (0..width * height)
        .into_par_iter()
        .map(|i| march(grid, &rays.ray(i % width, i / width), options.terminate))
        .collect();
    let mut picture = Picture::filled(width, height, [0.0; 3]);
    for (to, (colour, left, _)) in picture.rgb.iter_mut().zip(&pixels) {
        *to = (*colour + *left * background).to_array().map(|v| v as f32);
    }
    Ok(FloatFrame {
        picture,
        transmittance: pixels.iter().map(|p| p.1).collect(),
        samples: pixels.iter().map(|p| p.2).sum(),
    })
}

/// Colour, transmittance left and samples taken along a ray.
fn march(grid: &Grid, ray: &Ray, terminate: bool) -> (DVec3, f64, u64) {
    let coefficients = grid.layout().coefficients();
    let mut values = [0f64; 13];
    let values = &mut values[..grid.layout().channels()];
    let mut colour = DVec3::ZERO;
    let mut left = 1.0;
    let mut samples = 0;
    let d = ray.direction;
    let basis = [1.0, d.x, d.y, d.z];
    for k in 0..ray.samples {
        grid.sample(ray.at(k), values);
        samples += 1;
        let depth = values[0].max(0.0) * ray.step;
        if depth == 0.0 {
            continue;
        }
        let alpha = -(-depth).exp_m1();
        for c in 0..3 {
            let terms = &values[1 + c * coefficients..][..coefficients];
            let sum: f64 = terms.iter().zip(basis).map(|(v, b)| v * b).sum();
            colour[c] += left * alpha * sum.max(0.0);
        }
        left *= 1.0 - alpha;
        if terminate && left < STOP_BELOW {
            break;
        }
    }
    (colour, left, samples)
}
