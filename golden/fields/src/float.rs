//! Pixel-centric rendering in 64-bit floating point: all samples of a ray, ray after ray.

use glam::DVec3;
use rayon::prelude::*;

use super::{Along, CoordinateFrame, Field, FieldError, Sampling};
use potamoi_base::camera::{Camera, crossing};
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;

/// Maximum number of pixels in a picture.
const MAX_PIXELS: u64 = 1 << 26;
/// Maximum number of samples on a ray.
const MAX_SAMPLES: f64 = 1e6;

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

/// Buffers that a worker reuses from pixel to pixel.
pub(super) struct Worker {
    places: Vec<DVec3>,
    /// Features and weight of each visible sample on the ray.
    features: Vec<f64>,
    weights: Vec<f64>,
    pub(super) scratch: Vec<f64>,
}

/// A pixel, with its counts.
#[derive(Clone, Copy)]
pub(super) struct Pixel {
    colour: DVec3,
    left: f64,
    /// Sum of weights, and sum of weights times distances along the ray.
    weight: f64,
    moment: f64,
    pub(super) samples: u64,
    pub(super) gathered: u64,
    coloured: u64,
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
    let pixels: Vec<Pixel> = (0..width * height)
        .into_par_iter()
        .map_init(
            || Worker::new(field),
            |worker, i| {
                if only.is_some_and(|mask| !mask.has(i as usize)) {
                    return Pixel::CLEAR;
                }
                march(field, view, [i % width, i / width], worker)
            },
        )
        .collect();
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

impl Pixel {
    /// A pixel whose ray meets nothing.
    const CLEAR: Self = Self {
        colour: DVec3::ZERO,
        left: 1.0,
        weight: 0.0,
        moment: 0.0,
        samples: 0,
        gathered: 0,
        coloured: 0,
    };

    /// The weighted mean distance along the ray.
    fn distance(&self) -> f64 {
        if self.weight > 0.0 {
            self.moment / self.weight
        } else {
            f64::INFINITY
        }
    }
}

impl Worker {
    pub(super) fn new(field: &dyn Field) -> Self {
        Self {
            places: vec![DVec3::ZERO; field.tables().len()],
            features: vec![],
            weights: vec![],
            scratch: vec![],
        }
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

    fn within(
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
    fn distance(&self, k: u64) -> f64 {
        self.near + self.step * k as f64
    }

    /// World position of sample `k`.
    pub(super) fn at(&self, k: u64) -> DVec3 {
        self.between(k, 0.0)
    }

    /// World position a fraction of a step behind sample `k`.
    pub(super) fn between(&self, k: u64, part: f64) -> DVec3 {
        self.origin + self.direction * (self.near + self.step * (k as f64 + part))
    }
}

/// Marches a ray to where it stops: its samples, its gathered samples and its final transmittance.
/// The worker keeps the visible samples; `gathers` is called with the gathered ones.
pub(super) fn advance(
    field: &dyn Field,
    sampling: &Sampling,
    ray: &Samples,
    worker: &mut Worker,
    mut gathers: impl FnMut(u64),
) -> Pixel {
    let mut pixel = Pixel::CLEAR;
    let channels = field.channels();
    worker.features.clear();
    worker.weights.clear();
    for k in 0..ray.count {
        pixel.samples += 1;
        if !field.index(ray.at(k), &mut worker.places) {
            continue;
        }
        pixel.gathered += 1;
        gathers(k);
        let from = worker.features.len();
        worker.features.resize(from + channels, 0.0);
        let mut rest = &mut worker.features[from..];
        for (table, place) in field.tables().iter().zip(&worker.places) {
            let (own, other) = rest.split_at_mut(table.channels());
            table.gather(*place, own);
            rest = other;
        }
        let alpha = -(-field.depth(&worker.features[from..])).exp_m1();
        let weight = alpha * pixel.left;
        if alpha > sampling.least_opacity {
            pixel.left *= 1.0 - alpha;
        }
        if alpha > sampling.least_opacity && weight > sampling.least_weight {
            worker.weights.push(weight);
            pixel.weight += weight;
            pixel.moment += weight * ray.distance(k);
        } else {
            worker.features.truncate(from);
        }
        if pixel.left < sampling.stop {
            break;
        }
    }
    pixel.coloured = worker.weights.len() as u64;
    pixel
}

fn march(field: &dyn Field, view: &View<'_>, pixel: [u32; 2], worker: &mut Worker) -> Pixel {
    let View {
        camera,
        sampling,
        frame,
        directions,
    } = view;
    let ray = Samples::within(sampling, camera, *frame, pixel);
    let mut pixel = advance(field, sampling, &ray, worker, |_| ());
    let towards = match directions {
        true => ray.direction,
        false => DVec3::ZERO,
    };
    let samples = worker.features.chunks_exact(field.channels().max(1));
    for (features, weight) in samples.zip(&worker.weights) {
        pixel.colour += *weight * field.colour(features, towards, &mut worker.scratch);
    }
    pixel
}
