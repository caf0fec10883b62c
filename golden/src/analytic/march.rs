//! Ground truth: rays through the analytic field itself.

use glam::DVec3;
use rayon::prelude::*;

use super::field::Field;
use crate::camera::{Camera, crossing};
use crate::picture::Picture;

/// A ray stops once less than this of the light behind would be seen.
const STOP_BELOW: f64 = 3e-4;
/// Samples with a smaller weight in the pixel show no colour.
const LEAST: f64 = 1e-4;

/// A rendered field.
#[derive(Debug, Clone, PartialEq)]
pub struct Truth {
    /// The picture, background included.
    pub picture: Picture,
    /// Transmittance left at each pixel.
    pub transmittance: Vec<f64>,
    /// How far along its ray half of each pixel's light is taken, in the
    /// world; infinite where it is not.
    pub distance: Vec<f64>,
}

/// A ray's sum.
#[derive(Clone, Copy)]
struct Pixel {
    colour: DVec3,
    left: f64,
    half: f64,
}

/// Renders a field in steps of `scale` times what its probes ask for. The
/// camera has been checked.
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

/// Trapezoids of density, which are exact where it is linear, and the colour in
/// their middle. Every turn of the loop goes a step ahead, or more.
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
                let look = field.look(origin + direction * (t + 0.5 * step));
                pixel.colour += weight * look.along(direction);
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
    pixel
}
