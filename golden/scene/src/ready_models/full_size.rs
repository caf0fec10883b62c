//! Ready models with the sizes of the originals, for counts of a frame's work: accesses depend on
//! sizes and on what is visible, not on values.

use glam::{DVec3, Quat};
use potamoi_analytic::Analytic;
use potamoi_base::sh;
use potamoi_fields::algorithms::dvgo::Dvgo;
use potamoi_fields::algorithms::tensorf::Tensorf;
use potamoi_gaussians::{Cloud, CloudError};
use rand::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;

use super::grids;
use crate::SceneError;

/// Vertices of DirectVoxGO's grid (`num_voxels` of configs/default.py, fine stage).
const DVGO: usize = 160 * 160 * 160;
/// Vertices along an axis of TensoRF's (`N_voxel_final` of configs/lego.txt).
const TENSORF: usize = 300;
/// Degree of the harmonics of trained Gaussians.
const DEGREE: usize = 3;

/// DirectVoxGO, sampled at 160^3 vertices in the proportions of the scene.
pub(super) fn dvgo(analytic: Analytic) -> Result<Dvgo, SceneError> {
    Ok(grids::dvgo(&analytic.bake_of(DVGO)?)?)
}

/// TensoRF with planes and lines of 300 vertices along each axis, between those of the ready model.
pub(super) fn tensorf(analytic: Analytic) -> Result<Tensorf, SceneError> {
    Ok(grids::tensorf(&analytic.bake()?)?.resampled([TENSORF; 3])?)
}

/// As many Gaussians as trained scenes have: each of the cloud is replaced by `k` of its own
/// distribution, as large as `k^-1/4` of it, between copies of one size and a tiling. Together they
/// are as opaque. Harmonics are of degree 3, those above the cloud's being 0.
pub(super) fn replicated(cloud: &Cloud, count: usize) -> Result<Cloud, CloudError> {
    let k = (count as f64 / cloud.len() as f64).round().max(1.0);
    let size = k.powf(-0.25);
    let spread = (1.0 - size * size).sqrt();
    let mut random = Pcg64Mcg::seed_from_u64(0);
    // Nearly normal, of variance 1, without functions that differ from one machine to another.
    let mut normal = || 2.0 * ((0..3).map(|_| random.random::<f64>()).sum::<f64>() - 1.5);
    let all = cloud.len() * k as usize;
    let (mut means, mut scales, mut rotations) = (
        Vec::with_capacity(all),
        Vec::with_capacity(all),
        Vec::with_capacity(all),
    );
    let (mut opacities, mut colours) = (Vec::with_capacity(all), Vec::with_capacity(16 * all));
    for i in 0..cloud.len() {
        let [w, x, y, z] = cloud.rotations()[i];
        let turn = Quat::from_xyzw(x, y, z, w).normalize().as_dquat();
        let sigma = DVec3::from(cloud.log_scales()[i].map(|s| f64::from(s).exp()));
        let middle = DVec3::from(cloud.means()[i].map(f64::from));
        // k / sqrt(k) of them cover a point: (1 - alpha)^(1 / sqrt(k)) each.
        let opacity = 1.0 / (1.0 + (-f64::from(cloud.opacity_logits()[i])).exp());
        let through = (1.0 - opacity).powf(1.0 / k.sqrt());
        for _ in 0..k as usize {
            let aside = sigma * DVec3::new(normal(), normal(), normal()) * spread;
            means.push((middle + turn * aside).as_vec3().to_array());
            scales.push(cloud.log_scales()[i].map(|s| s + size.ln() as f32));
            rotations.push(cloud.rotations()[i]);
            opacities.push(((1.0 - through) / through).ln() as f32);
            colours.extend_from_slice(cloud.sh(i));
            let missing = sh::coefficients(DEGREE) - cloud.sh(i).len();
            colours.extend(std::iter::repeat_n([0.0; 3], missing));
        }
    }
    Cloud::new(DEGREE, means, scales, rotations, opacities, colours)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// The optical depth of a Gaussian, times the area of its two wide axes, is that of its copies.
    #[test]
    fn copies_are_as_opaque_as_what_they_replace() {
        let logits = [1.5f32, -2.0];
        let scales = [[-1.0f32, -2.0, -5.0], [0.5, 0.0, -0.5]];
        let one = Cloud::new(
            0,
            vec![[0.0; 3], [4.0, 0.0, 1.0]],
            scales.to_vec(),
            vec![[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, -0.5, 0.5]],
            logits.to_vec(),
            vec![[0.1, 0.2, 0.3]; 2],
        )
        .unwrap();
        let many = replicated(&one, 128).unwrap();
        assert_eq!((many.len(), many.degree()), (128, 3));
        let depth = |cloud: &Cloud, i: usize| {
            let opacity = 1.0 / (1.0 + (-f64::from(cloud.opacity_logits()[i])).exp());
            let [a, b, _] = cloud.log_scales()[i].map(f64::from);
            -(1.0 - opacity).ln() * (a + b).exp()
        };
        for i in 0..2 {
            let copies: f64 = (0..64).map(|k| depth(&many, 64 * i + k)).sum();
            assert!(
                (copies / depth(&one, i) - 1.0).abs() < 1e-5,
                "{i}: {copies}"
            );
        }
    }
}
