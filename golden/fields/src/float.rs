//! Pixel-centric rendering in 64-bit floating point: all samples of a ray, front to back.

use glam::DVec3;
use rayon::prelude::*;

use super::colour_queue::ColourQueue;
use super::pixel::Pixel;
use super::ray_tile::{RayTile, tiles};
use super::samples::Samples;
use super::{CoordinateFrame, Field, FieldError, Sampling};
use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;

/// Maximum number of pixels in a picture.
const MAX_PIXELS: u64 = 1 << 26;

/// A rendered frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldFrame {
    /// The picture, including the background.
    pub picture: Picture,
    /// Final transmittance per pixel.
    pub transmittance: Vec<f64>,
    /// Depth per pixel along the camera's axis: the weighted mean over its samples; infinite if no
    /// sample has a weight.
    pub depth: Vec<f64>,
    /// Samples within the bounds, up to where rays stop.
    pub samples: u64,
    /// Gathered samples: those where the field is not known to be empty.
    pub gathered: u64,
    /// Samples whose colour was computed.
    pub coloured: u64,
}

/// Options of the floating-point renderer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FloatOptions {
    /// Background, linear RGB.
    pub background: [f32; 3],
    /// Whether rays terminate early, at the field's threshold.
    pub terminate: bool,
    /// Whether colours depend on the viewing direction; if not, they are those along the zero
    /// vector.
    pub directions: bool,
    /// Factor of the field's thresholds of opacity and weight.
    pub thresholds: f64,
}

impl Default for FloatOptions {
    fn default() -> Self {
        Self {
            background: [0.0; 3],
            terminate: true,
            directions: true,
            thresholds: 1.0,
        }
    }
}

/// Renders a field over a linear RGB background.
///
/// # Errors
/// The camera has no pixels, or the sampling has too many samples.
pub fn render_float(
    field: &dyn Field,
    camera: &Camera,
    background: [f32; 3],
) -> Result<FieldFrame, FieldError> {
    let options = FloatOptions {
        background,
        ..FloatOptions::default()
    };
    render_masked(field, camera, &options, None)
}

/// As [`render_float`], but with options, and renders only the pixels of a mask, if any; the others
/// are background.
///
/// # Errors
/// Those of [`render_float`], or the mask does not have the camera's size.
pub fn render_masked(
    field: &dyn Field,
    camera: &Camera,
    options: &FloatOptions,
    only: Option<&Mask>,
) -> Result<FieldFrame, FieldError> {
    let local = field.local(camera)?;
    let sampling = field.sampling();
    let (own, frame): (&dyn Field, _) = match &local {
        Some(local) => (&*local.field, local.frame),
        None => {
            check(camera, &sampling)?;
            (field, CoordinateFrame::WORLD)
        }
    };
    check_mask(camera, only)?;
    let own_sampling = own.sampling();
    let view = View {
        camera,
        sampling: Sampling {
            stop: if options.terminate {
                sampling.stop
            } else {
                0.0
            },
            least_opacity: options.thresholds * own_sampling.least_opacity,
            least_weight: options.thresholds * own_sampling.least_weight,
            ..own_sampling
        },
        frame,
        directions: options.directions,
    };
    Ok(follow(own, &view, options.background, only))
}

/// The rays of a camera in a frame of reference.
struct View<'a> {
    camera: &'a Camera,
    sampling: Sampling,
    frame: CoordinateFrame,
    /// Whether colours depend on the viewing direction.
    directions: bool,
}

/// Renders a field whose sampling and mask have been checked.
fn follow(
    field: &dyn Field,
    view: &View<'_>,
    background: [f32; 3],
    only: Option<&Mask>,
) -> FieldFrame {
    let (width, height) = (view.camera.width, view.camera.height);
    let tiles = tiles([width, height]);
    let followed = tiles.into_par_iter().map_init(
        || {
            let queue = ColourQueue::new(field, view.directions);
            (RayTile::new(field), queue)
        },
        |(tile, queue), mut pixels| {
            if let Some(mask) = only {
                pixels.retain(|[x, y]| mask.has((y * width + x) as usize));
            }
            let rays = pixels.iter().map(|pixel| view.samples(*pixel));
            let rays: Vec<Samples> = rays.collect();
            let made = tile.follow(&view.sampling, &rays, |_, _| (), Some(queue));
            (pixels, made)
        },
    );
    let followed: Vec<_> = followed.collect();
    let mut pixels = vec![Pixel::CLEAR; width as usize * height as usize];
    for ([x, y], pixel) in followed
        .into_iter()
        .flat_map(|(at, made)| at.into_iter().zip(made))
    {
        pixels[(y * width + x) as usize] = pixel;
    }
    let behind = DVec3::from(background.map(f64::from));
    let mut picture = Picture::filled(width, height, [0.0; 3]);
    for (to, pixel) in picture.rgb.iter_mut().zip(&pixels) {
        let colour = pixel.colour + pixel.left * behind;
        *to = colour.to_array().map(|v| v as f32);
    }
    FieldFrame {
        picture,
        transmittance: pixels.iter().map(|p| p.left).collect(),
        depth: (0..)
            .zip(&pixels)
            .map(|(i, p)| p.distance() * view.frame.edge * view.camera.slant(i))
            .collect(),
        samples: pixels.iter().map(|p| p.samples).sum(),
        gathered: pixels.iter().map(|p| p.gathered).sum(),
        coloured: pixels.iter().map(|p| p.coloured).sum(),
    }
}

impl View<'_> {
    /// The samples on the ray through the centre of a pixel.
    fn samples(&self, pixel: [u32; 2]) -> Samples {
        Samples::within(&self.sampling, self.camera, self.frame, pixel)
    }
}

/// Checks that the samples along the camera's rays can be counted.
pub(super) fn check(camera: &Camera, sampling: &Sampling) -> Result<(), FieldError> {
    let refuse = |part, found: String, expected: &str| {
        Err(FieldError::Part {
            part,
            found,
            expected: expected.to_owned(),
        })
    };
    let pixels = u64::from(camera.width) * u64::from(camera.height);
    if pixels == 0 || pixels > MAX_PIXELS {
        let found = format!("{} x {}", camera.width, camera.height);
        return refuse("camera size", found, "1 to 67108864 pixels");
    }
    sampling.check()
}

/// Checks that a mask has the camera's size.
pub(super) fn check_mask(camera: &Camera, only: Option<&Mask>) -> Result<(), FieldError> {
    match only {
        Some(mask) if mask.size() != [camera.width, camera.height] => Err(FieldError::Part {
            part: "mask",
            found: format!("{:?} pixels", mask.size()),
            expected: format!("the camera's {} x {}", camera.width, camera.height),
        }),
        _ => Ok(()),
    }
}
