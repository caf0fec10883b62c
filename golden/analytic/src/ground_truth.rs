//! Ground truth: ray marching of the analytic field itself.

use glam::DVec3;
use rayon::prelude::*;

use super::field::Field;
use potamoi_base::camera::{Camera, crossing};
use potamoi_base::picture::Picture;

/// Early-termination threshold (transmittance).
const STOP_BELOW: f64 = 3e-4;
/// Weight threshold: samples of a smaller weight get no colour.
const LEAST: f64 = 1e-4;

/// Successive steps of a ray share one colour while their weight in the pixel, times their length
/// squared in voxel edges, is at most this: a fraction of the value of the heaviest single steps
/// through a surface.
const TOGETHER: f64 = 0.0006;

/// A rendered field.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// The picture, including the background.
    pub picture: Picture,
    /// Final transmittance per pixel.
    pub transmittance: Vec<f64>,
    /// Distance along each pixel's ray at which half of its light is absorbed, in world units;
    /// infinite if less is.
    pub distance: Vec<f64>,
}

/// Sums of a ray.
#[derive(Clone, Copy)]
struct Pixel {
    colour: DVec3,
    left: f64,
    half: f64,
}

/// A part of a ray with one colour.
#[derive(Clone, Copy)]
struct Part {
    from: f64,
    to: f64,
    /// Its weight in the pixel, and the sum of weights times positions.
    weight: f64,
    moment: f64,
}

impl Part {
    fn with(self, next: Self) -> Self {
        Self {
            from: self.from,
            to: next.to,
            weight: self.weight + next.weight,
            moment: self.moment + next.moment,
        }
    }

    fn spread(self) -> f64 {
        self.weight * (self.to - self.from).powi(2)
    }

    /// The colour at its centre of mass, times its weight.
    fn colour(self, field: &dyn Field, origin: DVec3, direction: DVec3) -> DVec3 {
        let at = origin + direction * (self.moment / self.weight);
        self.weight * field.look(at).along(direction)
    }
}

/// Renders a field with steps of `scale` times those of its probes. The camera has been checked.
pub(super) fn render(
    field: &dyn Field,
    camera: &Camera,
    background: [f32; 3],
    scale: f64,
) -> Truth {
    let (width, height) = (camera.width, camera.height);
    let bounds = field.frame().bounds();
    let pixels: Vec<Pixel> = (0..width * height)
        .into_par_iter()
        .map(|i| {
            let (origin, direction) = camera.ray(i % width, i / width);
            ray(field, bounds, origin, direction, scale)
        })
        .collect();
    let behind = DVec3::from(background.map(f64::from));
    let mut picture = Picture::filled(width, height, [0.0; 3]);
    for (to, pixel) in picture.rgb.iter_mut().zip(&pixels) {
        let colour = pixel.colour + pixel.left * behind;
        *to = colour.to_array().map(|v| v as f32);
    }
    Truth {
        picture,
        transmittance: pixels.iter().map(|p| p.left).collect(),
        distance: pixels.iter().map(|p| p.half).collect(),
    }
}

/// Integrates density by trapezoids, which are exact where it is linear, and takes the colour in
/// the middle of one or several of them. Every iteration advances by at least one step.
fn ray(
    field: &dyn Field,
    bounds: [DVec3; 2],
    origin: DVec3,
    direction: DVec3,
    scale: f64,
) -> Pixel {
    let [mut t, far] = crossing(bounds, origin, direction, [0.0, f64::INFINITY]);
    let mut pixel = Pixel {
        colour: DVec3::ZERO,
        left: 1.0,
        half: f64::INFINITY,
    };
    // Not a number is not less than another.
    if !(t < far && far.is_finite()) {
        return pixel;
    }
    // Errors of a part's colour fall with its length squared, as those of a
    // step do with the step.
    let together = TOGETHER * field.frame().voxel.powi(2) * scale.powi(3);
    let mut part: Option<Part> = None;
    let mut here = field.probe(origin + direction * t);
    while t < far {
        let step = here.step * scale;
        if here.clearance > step {
            t += here.clearance;
            here = field.probe(origin + direction * t);
            continue;
        }
        let step = step.min(far - t);
        let next = field.probe(origin + direction * (t + step));
        let depth = 0.5 * step * (here.density.max(0.0) + next.density.max(0.0));
        if depth > 0.0 {
            let alpha = -(-depth).exp_m1();
            let weight = alpha * pixel.left;
            if weight > LEAST {
                let next = Part {
                    from: t,
                    to: t + step,
                    weight,
                    moment: weight * (t + 0.5 * step),
                };
                part = match part {
                    Some(last) if last.with(next).spread() <= together => Some(last.with(next)),
                    Some(last) => {
                        pixel.colour += last.colour(field, origin, direction);
                        Some(next)
                    }
                    None => Some(next),
                };
            }
            pixel.left -= weight;
            if pixel.left < 0.5 && pixel.half.is_infinite() {
                pixel.half = t + step;
            }
            if pixel.left < STOP_BELOW {
                break;
            }
        }
        // A last step may be too short to move t, and ends the ray.
        if t + step <= t {
            break;
        }
        t += step;
        here = next;
    }
    if let Some(last) = part {
        pixel.colour += last.colour(field, origin, direction);
    }
    pixel
}
