//! Projection of Gaussians to the screen.

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::footprint::Footprint;
use super::profile::Rules;
use potamoi_base::camera::Camera;
use potamoi_base::sh;
use potamoi_gaussians::{Cloud, rotation, sigmoid};

/// A projected Gaussian.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Projected {
    /// Index of the Gaussian in the cloud.
    pub index: usize,
    /// View depth.
    pub depth: f64,
    /// Mean in pixels; pixel centres lie at integer + the profile's
    /// `pixel_centre`.
    pub mean: DVec2,
    /// Shape.
    pub footprint: Footprint,
    /// Opacity, 0 to 1; for an antialiased model after the pixel filter's compensation.
    pub opacity: f64,
    /// View-dependent colour, at least 0.
    pub colour: DVec3,
}

impl Projected {
    /// Alpha at an offset from the mean, before cap and skip.
    #[must_use]
    pub fn alpha(&self, offset: DVec2) -> f64 {
        self.opacity * (-0.5 * self.footprint.distance_squared(offset)).exp()
    }
}

/// The projection from the world to the screen of one camera.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Projection<'a> {
    cloud: &'a Cloud,
    camera: &'a Camera,
    rules: &'a Rules,
    eye: DVec3,
    /// Degree of the spherical harmonics that are evaluated.
    degree: usize,
}

impl<'a> Projection<'a> {
    /// A projection with spherical harmonics up to a degree, at most the stored one.
    pub(crate) fn new(
        cloud: &'a Cloud,
        camera: &'a Camera,
        rules: &'a Rules,
        degree: usize,
    ) -> Self {
        Self {
            cloud,
            camera,
            rules,
            eye: camera.position(),
            degree: degree.min(cloud.degree()),
        }
    }

    fn world(&self, index: usize) -> DVec3 {
        DVec3::from(self.cloud.means()[index].map(f64::from))
    }

    fn view(&self, index: usize) -> DVec3 {
        let world = self.world(index);
        self.camera.world_to_camera.transform_point3(world)
    }

    /// The rules.
    pub(crate) fn rules(&self) -> &Rules {
        self.rules
    }

    /// View depth of a Gaussian.
    pub(crate) fn depth(&self, index: usize) -> f64 {
        self.view(index).z
    }

    /// (view depth, index) of the Gaussians behind the near plane, in cloud order.
    pub(crate) fn depths(&self) -> Vec<(f64, usize)> {
        (0..self.cloud.len())
            .into_par_iter()
            .map(|i| (self.view(i).z, i))
            .filter(|(depth, _)| self.rules.sees(*depth))
            .collect()
    }

    /// Projects a Gaussian of [`Projection::depths`].
    pub(crate) fn project(&self, index: usize) -> Projected {
        let (cloud, camera) = (self.cloud, self.camera);
        let view = self.view(index);
        let slope = view.truncate() / view.z;
        let half =
            DVec2::new(f64::from(camera.width), f64::from(camera.height)) / 2.0 / camera.focal;
        let limit = half * self.rules.guard;
        let held = slope.clamp(-limit, limit);

        let scale = DVec3::from(cloud.log_scales()[index].map(|s| f64::from(s).exp()));
        let axes = camera.world_to_camera.matrix3
            * rotation(cloud.rotations()[index])
            * DMat3::from_diagonal(scale);
        let per_depth = camera.focal / view.z;
        let footprint = Footprint::new(
            per_depth.x * (axes.row(0) - held.x * axes.row(2)),
            per_depth.y * (axes.row(1) - held.y * axes.row(2)),
            self.rules.dilation,
        );
        let opacity = sigmoid(f64::from(cloud.opacity_logits()[index]));
        let towards = match self.degree {
            // Seen alike from everywhere.
            0 => DVec3::ZERO,
            _ => (self.world(index) - self.eye).normalize_or_zero(),
        };
        Projected {
            index,
            depth: view.z,
            mean: slope * camera.focal + camera.centre - 0.5 + self.rules.pixel_centre,
            footprint,
            opacity: match cloud.is_antialiased() {
                true => opacity * footprint.kept(),
                false => opacity,
            },
            colour: sh::colour(&cloud.sh(index)[..sh::coefficients(self.degree)], towards),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::Profile;

    fn one(mean: [f32; 3], log_scale: [f32; 3], rotation: [f32; 4]) -> Cloud {
        Cloud::new(
            0,
            vec![mean],
            vec![log_scale],
            vec![rotation],
            vec![0.0],
            vec![[0.0; 3]],
        )
        .unwrap()
    }

    fn project(cloud: &Cloud, camera: &Camera, rules: &Rules) -> Vec<Projected> {
        let projection = Projection::new(cloud, camera, rules, sh::MAX_DEGREE);
        let depths = projection.depths();
        depths.iter().map(|d| projection.project(d.1)).collect()
    }

    fn camera() -> Camera {
        Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 1.0, 200, 100)
    }

    #[test]
    fn a_ball_on_the_axis_projects_to_a_disc() {
        let c = camera();
        let p = project(
            &one([0.0, 0.0, 4.0], [-2.0; 3], [1.0, 0.0, 0.0, 0.0]),
            &c,
            &Profile::Gsplat.rules(),
        );
        let sigma = (-2f64).exp() * c.focal.x / 4.0;
        assert_eq!(p[0].mean, DVec2::new(100.0, 50.0));
        let [xx, xy, yy] = p[0].footprint.covariance;
        assert!((xx - sigma * sigma - 0.3).abs() < 1e-9 && (yy - xx).abs() < 1e-9);
        assert!(xy.abs() < 1e-12);
        assert_eq!(p[0].opacity, 0.5);
        assert_eq!(p[0].colour, DVec3::splat(0.5));
    }

    #[test]
    fn the_covariance_is_the_jacobians_by_finite_differences() {
        let c = camera();
        let (mean, log_scale) = ([0.6f32, -0.3, 3.0], [-3.0f32, -2.0, -4.0]);
        let quaternion = [0.9f32, 0.3, -0.2, 0.4];
        let p = project(
            &one(mean, log_scale, quaternion),
            &c,
            &Profile::Gsplat.rules(),
        );
        let m = DVec3::from(mean.map(f64::from));
        let screen = |w: DVec3| w.truncate() / w.z * c.focal;
        let h = 1e-5;
        let r = rotation(quaternion);
        let mut cov = [0.3, 0.0, 0.3];
        for axis in 0..3 {
            let step = r.col(axis) * f64::from(log_scale[axis]).exp();
            let d = (screen(m + step * h) - screen(m - step * h)) / (2.0 * h);
            cov[0] += d.x * d.x;
            cov[1] += d.x * d.y;
            cov[2] += d.y * d.y;
        }
        for (a, b) in p[0].footprint.covariance.iter().zip(cov) {
            assert!((a - b).abs() < 1e-6 * cov[0], "{a} {b}");
        }
    }

    #[test]
    fn what_lies_at_or_behind_the_near_plane_is_gone() {
        for profile in Profile::ALL {
            let rules = profile.rules();
            for z in [-5.0, -0.0, 0.0, 0.005] {
                let cloud = one([0.0, 0.0, z], [0.0; 3], [0.0; 4]);
                assert!(project(&cloud, &camera(), &rules).is_empty(), "{z}");
            }
        }
        let cloud = one([0.0, 0.0, 0.2], [0.0; 3], [0.0; 4]);
        // 0.2 as f32 is just above 0.2.
        assert_eq!(project(&cloud, &camera(), &Profile::Inria.rules()).len(), 1);
    }

    #[test]
    fn extreme_sizes_stay_finite() {
        for scale in [-1e38f32, -100.0, 88.0] {
            for mean in [[3e38f32, -3e38, 3e38], [1e30, 0.0, 0.3], [0.0, 0.0, 0.3]] {
                let cloud = one(mean, [scale, -50.0, scale], [1.0, 0.2, 0.3, 0.1]);
                for p in project(&cloud, &camera(), &Profile::Inria.rules()) {
                    let f = p.footprint;
                    assert!(p.mean.is_finite());
                    assert!(f.covariance.iter().all(|v| v.is_finite()), "{f:?}");
                    assert!(f.factor.iter().all(|v| v.abs() < 1.8258), "{f:?}");
                    assert!(f.determinant.is_finite() && f.determinant > 0.0);
                }
            }
        }
    }
}
