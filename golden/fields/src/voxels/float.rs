//! The renderer in 64-bit floating point, pixel by pixel.

use glam::DVec3;
use rayon::prelude::*;

use super::grid::Grid;
use super::ray::{Ray, Rays};
use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;
use potamoi_march::MarchError;

/// A ray stops once less than this of the light behind would be seen, unless told otherwise.
pub const STOP_BELOW: f64 = 1e-3;

/// How to render in floating point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FloatOptions {
    /// Voxel edges from sample to sample.
    pub step: f64,
    /// Whether rays stop.
    pub terminate: bool,
    /// Where.
    pub stop_below: f64,
    /// Linear RGB behind everything.
    pub background: [f32; 3],
    /// Whether colours that are linear in the direction are seen from it.
    pub directions: bool,
}

impl Default for FloatOptions {
    fn default() -> Self {
        Self {
            step: 0.5,
            terminate: true,
            stop_below: STOP_BELOW,
            background: [0.0; 3],
            directions: true,
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
    /// Depth of each pixel along the camera's axis: the mean of its samples,
    /// each with its weight; infinite where nothing has a weight.
    pub depth: Vec<f64>,
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
) -> Result<FloatFrame, MarchError> {
    render_masked(grid, camera, options, None)
}

/// As [`render_float`], but of a mask its pixels alone; the others are
/// background.
///
/// # Errors
/// As [`render_float`], and for a mask of another size than the camera's.
pub fn render_masked(
    grid: &Grid,
    camera: &Camera,
    options: &FloatOptions,
    only: Option<&Mask>,
) -> Result<FloatFrame, MarchError> {
    let rays = Rays::new(grid, camera, options.step)?;
    let [width, height] = rays.size();
    if let Some(mask) = only.filter(|mask| mask.size() != rays.size()) {
        return Err(MarchError::Option {
            field: "mask",
            value: format!("{:?} pixels", mask.size()),
            expected: "a mask of the camera's size",
        });
    }
    let background = DVec3::from(options.background.map(f64::from));
    let pixels: Vec<Pixel> = (0..width * height)
        .into_par_iter()
        .map(|i| {
            if only.is_some_and(|mask| !mask.has(i as usize)) {
                return Pixel::CLEAR;
            }
            march(grid, &rays.ray(i % width, i / width), options)
        })
        .collect();
    let mut picture = Picture::filled(width, height, [0.0; 3]);
    for (to, pixel) in picture.rgb.iter_mut().zip(&pixels) {
        let colour = pixel.colour + pixel.left * background;
        *to = colour.to_array().map(|v| v as f32);
    }
    Ok(FloatFrame {
        picture,
        transmittance: pixels.iter().map(|p| p.left).collect(),
        depth: (0..)
            .zip(&pixels)
            .map(|(i, p)| p.distance() * grid.voxel() * camera.slant(i))
            .collect(),
        samples: pixels.iter().map(|p| p.samples).sum(),
    })
}

/// What a ray adds up to.
#[derive(Clone, Copy)]
struct Pixel {
    colour: DVec3,
    left: f64,
    /// Sums of weights, and of weights times distances along the ray.
    weight: f64,
    moment: f64,
    samples: u64,
}

impl Pixel {
    /// Of a ray that meets nothing.
    const CLEAR: Self = Self {
        colour: DVec3::ZERO,
        left: 1.0,
        weight: 0.0,
        moment: 0.0,
        samples: 0,
    };

    fn distance(&self) -> f64 {
        if self.weight > 0.0 {
            self.moment / self.weight
        } else {
            f64::INFINITY
        }
    }
}

fn march(grid: &Grid, ray: &Ray, options: &FloatOptions) -> Pixel {
    let coefficients = grid.layout().coefficients();
    let mut values = [0f64; 13];
    let values = &mut values[..grid.layout().channels()];
    let mut pixel = Pixel::CLEAR;
    let d = ray.direction;
    let basis = [1.0, d.x, d.y, d.z];
    let terms = if options.directions { coefficients } else { 1 };
    for k in 0..ray.samples {
        grid.sample(ray.at(k), values);
        pixel.samples += 1;
        let depth = values[0].max(0.0) * ray.step;
        if depth == 0.0 {
            continue;
        }
        let alpha = -(-depth).exp_m1();
        for c in 0..3 {
            let own = &values[1 + c * coefficients..][..terms];
            let sum: f64 = own.iter().zip(basis).map(|(v, b)| v * b).sum();
            pixel.colour[c] += pixel.left * alpha * sum.max(0.0);
        }
        pixel.weight += pixel.left * alpha;
        pixel.moment += pixel.left * alpha * ray.distance(k);
        pixel.left *= 1.0 - alpha;
        if options.terminate && pixel.left < options.stop_below {
            break;
        }
    }
    pixel
}
