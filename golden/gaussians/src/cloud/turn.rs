//! Conversion of clouds between axis conventions, and their placement in a world.

use glam::{DQuat, DVec3};
use rayon::prelude::*;

use super::Cloud;
use crate::axes::{self, Axes};
use potamoi_base::sh;

/// Minimum number of Gaussians a thread.
const BLOCK: usize = 1 << 12;

impl Cloud {
    /// Converts a cloud from file axes to cloud axes: centres, axes of the ellipsoids, and
    /// harmonics.
    pub(crate) fn turned(mut self, axes: Axes) -> Self {
        if axes == Axes::RIGHT_DOWN_FRONT {
            return self;
        }
        (self.means.par_iter_mut().with_min_len(BLOCK)).for_each(|own| *own = axes.point(*own));
        (self.log_scales.par_iter_mut().with_min_len(BLOCK))
            .for_each(|own| *own = axes.lengths(*own));
        (self.rotations.par_iter_mut().with_min_len(BLOCK))
            .for_each(|own| *own = axes.quaternion(*own));
        let each = sh::coefficients(self.degree);
        if each > 1 {
            let mixed = axes.harmonics();
            (self.sh.par_chunks_mut(each).with_min_len(BLOCK)).for_each(|own| turn(own, &mixed));
        }
        self
    }
}

/// A place in a world: points are scaled, rotated, then moved.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placement {
    /// Factor of lengths, above 0.
    pub(crate) scale: f64,
    /// Rotation, a unit quaternion.
    pub(crate) rotation: DQuat,
    /// Where the origin comes to lie.
    pub(crate) translation: DVec3,
}

impl Cloud {
    /// Places a cloud in a world: centres, sizes, rotations and harmonics. Without a rotation or a
    /// scale the bits of rotations, harmonics and sizes stay.
    pub(crate) fn placed(mut self, at: &Placement) -> Self {
        let is_turned = at.rotation != DQuat::IDENTITY;
        let log_scale = at.scale.ln();
        (self.means.par_iter_mut().with_min_len(BLOCK)).for_each(|own| {
            let before = DVec3::from(own.map(f64::from)) * at.scale;
            let turned = match is_turned {
                true => at.rotation * before,
                false => before,
            };
            *own = (turned + at.translation).to_array().map(|v| v as f32);
        });
        if at.scale != 1.0 {
            let scaled = |v: f32| (f64::from(v) + log_scale) as f32;
            (self.log_scales.par_iter_mut().with_min_len(BLOCK))
                .for_each(|own| *own = own.map(scaled));
        }
        if !is_turned {
            return self;
        }
        (self.rotations.par_iter_mut().with_min_len(BLOCK)).for_each(|own| {
            let [w, x, y, z] = match own.iter().all(|v| *v == 0.0) {
                // A quaternion of length 0 is no rotation.
                true => [1.0, 0.0, 0.0, 0.0],
                false => own.map(f64::from),
            };
            let turned = at.rotation * DQuat::from_xyzw(x, y, z, w);
            *own = [turned.w, turned.x, turned.y, turned.z].map(|v| v as f32);
        });
        let each = sh::coefficients(self.degree);
        if each > 1 {
            let back = at.rotation.inverse();
            let mixed = axes::harmonics(|own| back * own);
            (self.sh.par_chunks_mut(each).with_min_len(BLOCK)).for_each(|own| turn(own, &mixed));
        }
        self
    }
}

/// Converts the coefficients of one Gaussian; bands do not mix.
fn turn(own: &mut [[f32; 3]], mixed: &[[f64; 16]; 16]) {
    let mut before = [[0.0f32; 3]; 16];
    before[..own.len()].copy_from_slice(own);
    for (k, to) in own.iter_mut().enumerate().skip(1) {
        let degree = k.isqrt();
        let band = degree * degree..(degree + 1) * (degree + 1);
        *to = [0, 1, 2].map(|channel| {
            let all = band
                .clone()
                .map(|j| mixed[k][j] * f64::from(before[j][channel]));
            all.sum::<f64>() as f32
        });
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use glam::{DMat3, DVec3};

    use super::*;
    use crate::rotation;

    fn cloud() -> Cloud {
        let sh = (0u8..16).map(|k| [0u8, 1, 2].map(|c| (f32::from(k) * 1.7 + f32::from(c)).sin()));
        Cloud::new(
            3,
            vec![[1.0, -2.0, 0.5]],
            vec![[-1.0, -3.0, -2.0]],
            vec![[0.9, 0.3, -0.2, 0.4]],
            vec![0.0],
            sh.collect(),
        )
        .unwrap()
    }

    fn covariance(cloud: &Cloud) -> DMat3 {
        let scale = DVec3::from(cloud.log_scales()[0].map(|s| f64::from(s).exp()));
        let axes = rotation(cloud.rotations()[0]) * DMat3::from_diagonal(scale);
        axes * axes.transpose()
    }

    /// Centre, covariance and colours of degree 3, where the model is placed.
    #[test]
    fn what_is_seen_is_placed() {
        let before = cloud();
        let direction = DVec3::new(0.36, 0.48, -0.8);
        let at = Placement {
            scale: 2.5,
            rotation: DQuat::from_xyzw(0.1, -0.7, 0.5, 0.5).normalize(),
            translation: DVec3::new(1.0, 2.0, -3.0),
        };
        let after = cloud().placed(&at);
        let p = DMat3::from_quat(at.rotation) * at.scale;
        let mean = p * DVec3::from(before.means()[0].map(f64::from)) + at.translation;
        let off = DVec3::from(after.means()[0].map(f64::from)) - mean;
        assert!(off.length() < 1e-6, "{off}");
        let expected = p * covariance(&before) * p.transpose();
        let off = (covariance(&after) - expected).to_cols_array();
        assert!(off.iter().all(|v| v.abs() < 1e-6), "{off:?}");
        let [a, b] = [
            sh::colour(before.sh(0), direction),
            sh::colour(after.sh(0), at.rotation * direction),
        ];
        assert!((a - b).length() < 1e-6, "{a} {b}");
        let naive = sh::colour(before.sh(0), at.rotation * direction);
        assert!((a - naive).length() > 0.01);
        let still = Placement {
            scale: 1.0,
            rotation: DQuat::IDENTITY,
            translation: DVec3::ZERO,
        };
        assert_eq!(cloud().placed(&still), before);
    }

    /// Centre, covariance and colours of degree 3, in all 48 axes.
    #[test]
    fn what_is_seen_turns_with_the_axes() {
        let before = cloud();
        let direction = DVec3::new(0.36, 0.48, -0.8);
        for axes in Axes::all() {
            let after = cloud().turned(axes);
            let p = DMat3::from_cols_array_2d(&[
                axes.point([1.0, 0.0, 0.0]),
                axes.point([0.0, 1.0, 0.0]),
                axes.point([0.0, 0.0, 1.0]),
            ]);
            let mean = p * DVec3::from(before.means()[0].map(f64::from));
            assert_eq!(DVec3::from(after.means()[0].map(f64::from)), mean);
            let expected = p * covariance(&before) * p.transpose();
            let off = (covariance(&after) - expected).to_cols_array();
            assert!(off.iter().all(|v| v.abs() < 1e-15), "{axes}");
            // A rotation that is not turned is another ellipsoid.
            let own = rotation(after.rotations()[0]);
            if p.determinant() > 0.0 {
                let turned = p * rotation(before.rotations()[0]) * p.transpose();
                let off = (own - turned).to_cols_array();
                assert!(off.iter().all(|v| v.abs() < 1e-15), "{axes}");
            }
            let [a, b] = [
                sh::colour(before.sh(0), direction),
                sh::colour(after.sh(0), p * direction),
            ];
            // Coefficients of 32 bits, 16 of them of about 1.
            assert!((a - b).length() < 1e-6, "{axes}: {a} {b}");
            let naive = sh::colour(before.sh(0), p * direction);
            assert!(
                axes == Axes::RIGHT_DOWN_FRONT || (a - naive).length() > 0.01,
                "{axes}"
            );
        }
    }
}
