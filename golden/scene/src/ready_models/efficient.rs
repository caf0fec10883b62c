//! EfficientNeRF models, sampled at the centres of fine cells as wide as the voxels of a scene's grid.

use glam::DVec3;

use potamoi_analytic::{Appearance, Sampler};
use potamoi_base::sh;
use potamoi_fields::FieldError;
use potamoi_fields::algorithms::efficient::{CHANNELS, COEFFICIENTS, EfficientNerf, FINE};

/// Minimum distance of colours from 0 and 1, where logits are infinite.
const MARGIN: f64 = 1.0 / 512.0;

/// The tree of a scene.
pub(crate) fn tree(scene: Sampler) -> Result<EfficientNerf, FieldError> {
    let cells = scene.points().map(|points| (points - 1).div_ceil(FINE));
    let basis: Vec<_> = scene.directions().map(|d| (d, sh::basis(d))).collect();
    EfficientNerf::sampled(cells, scene.corner(), scene.voxel(), |at, values| {
        let depth = scene.depth(at);
        if depth <= 0.0 {
            return false;
        }
        // The inverse of softplus.
        values[0] = depth.exp_m1().ln() as f32;
        if !scene.is_dark(depth) {
            colours(&scene.look(at), &basis, values);
        }
        true
    })
}

/// The logits of the colours, projected to spherical harmonics.
fn colours(look: &Appearance, basis: &[(DVec3, [f64; 16])], values: &mut [f32; CHANNELS]) {
    let logits = |d: DVec3| {
        let held = look
            .along(d)
            .clamp(DVec3::splat(MARGIN), DVec3::splat(1.0 - MARGIN));
        held.to_array().map(|v| (v / (1.0 - v)).ln())
    };
    if look.is_matte() {
        for (c, logit) in logits(DVec3::Z).into_iter().enumerate() {
            values[1 + c * COEFFICIENTS] = (logit / sh::CONSTANT) as f32;
        }
        return;
    }
    let area = 4.0 * std::f64::consts::PI / basis.len() as f64;
    let mut sums = [[0.0; COEFFICIENTS]; 3];
    for (d, basis) in basis {
        for (sums, logit) in sums.iter_mut().zip(logits(*d)) {
            for (sum, b) in sums.iter_mut().zip(basis) {
                *sum += area * logit * b;
            }
        }
    }
    for (to, sum) in values[1..].iter_mut().zip(sums.as_flattened()) {
        *to = *sum as f32;
    }
}
