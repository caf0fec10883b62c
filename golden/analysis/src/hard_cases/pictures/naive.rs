//! The obvious renderer: the equations of 3D Gaussian splatting in 32-bit floats, one pixel after
//! the other, without any guard.

use potamoi_base::picture::Picture;

use super::form::Form;
use super::scenes::{Gaussian, SIZE, camera};

/// A Gaussian on screen.
struct Spot {
    depth: f32,
    mean: [f32; 2],
    conic: [f32; 3],
    alpha: f32,
    colour: [f32; 3],
}

fn project(g: &Gaussian, dilation: f32) -> Spot {
    let [w, x, y, z] = g.rotation;
    let length = (w * w + x * x + y * y + z * z).sqrt();
    let [w, x, y, z] = [w / length, x / length, y / length, z / length];
    let r = [
        [
            1.0 - 2.0 * (y * y + z * z),
            2.0 * (x * y - w * z),
            2.0 * (x * z + w * y),
        ],
        [
            2.0 * (x * y + w * z),
            1.0 - 2.0 * (x * x + z * z),
            2.0 * (y * z - w * x),
        ],
        [
            2.0 * (x * z - w * y),
            2.0 * (y * z + w * x),
            1.0 - 2.0 * (x * x + y * y),
        ],
    ];
    let s = g.log_scale.map(f32::exp);
    let mut sigma = [[0f32; 3]; 3];
    for (i, row) in sigma.iter_mut().enumerate() {
        for (j, v) in row.iter_mut().enumerate() {
            *v = (0..3).map(|k| r[i][k] * r[j][k] * s[k] * s[k]).sum();
        }
    }
    let focal = camera().focal.x as f32;
    let [mx, my, mz] = g.mean;
    let jacobian = [
        [focal / mz, 0.0, -focal * mx / (mz * mz)],
        [0.0, focal / mz, -focal * my / (mz * mz)],
    ];
    let entry = |a: usize, b: usize| -> f32 {
        let terms = (0..9).map(|k| jacobian[a][k / 3] * sigma[k / 3][k % 3] * jacobian[b][k % 3]);
        terms.sum()
    };
    let (xx, xy, yy) = (entry(0, 0) + dilation, entry(0, 1), entry(1, 1) + dilation);
    let det = xx * yy - xy * xy;
    let e = g.logit.exp();
    let centre = camera().centre.as_vec2();
    Spot {
        depth: mz,
        mean: [
            mx / mz * focal + centre.x - 0.5,
            my / mz * focal + centre.y - 0.5,
        ],
        conic: [yy / det, -xy / det, xx / det],
        alpha: e / (1.0 + e),
        colour: g.colour.map(|c| (0.282_094_8 * c + 0.5).max(0.0)),
    }
}

/// The picture on black, pixel centres at whole numbers.
#[must_use]
pub fn render(gaussians: &[Gaussian], form: Form) -> Picture {
    let dilation = if form == Form::Undilated { 0.0 } else { 0.3 };
    let mut spots: Vec<Spot> = gaussians.iter().map(|g| project(g, dilation)).collect();
    if form == Form::Reversed {
        spots.reverse();
    }
    spots.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    let [width, height] = SIZE;
    let mut picture = Picture::filled(width, height, [0.0; 3]);
    for (i, pixel) in picture.rgb.iter_mut().enumerate() {
        let at = [(i as u32 % width) as f32, (i as u32 / width) as f32];
        let mut left = 1f32;
        for spot in &spots {
            let [dx, dy] = [at[0] - spot.mean[0], at[1] - spot.mean[1]];
            let [a, b, c] = spot.conic;
            let power = -0.5 * (a * dx * dx + c * dy * dy) - b * dx * dy;
            let alpha = spot.alpha * power.exp();
            if alpha < 1.0 / 255.0 {
                continue;
            }
            for (sum, colour) in pixel.iter_mut().zip(spot.colour) {
                *sum += colour * alpha * left;
            }
            left *= 1.0 - alpha;
            if form == Form::Transmittance16 {
                left = (left * 65_536.0).floor() / 65_536.0;
            }
            if left < 1e-4 {
                break;
            }
        }
    }
    picture
}
