//! Cameras that look at a point from a distance.

use glam::{DAffine3, DVec3, dvec3};

use potamoi_base::camera::Camera;
use potamoi_gaussians::Cloud;

/// Position of a camera that looks at a point.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orbit {
    /// Degrees about the vertical axis; 0 looks along +z.
    pub azimuth: f64,
    /// Degrees above the horizon.
    pub elevation: f64,
    /// Distance from the point, in the scene's units.
    pub distance: f64,
    /// Vertical field of view in degrees.
    pub fov: f64,
    /// The point in the middle of the picture.
    pub target: DVec3,
}

/// Fraction of Gaussians, nearest to the median, that a default view frames. A few distant ones
/// would reduce the rest to a speck.
const FRAMED: f64 = 0.95;

impl Orbit {
    /// The direction and field of view of a camera that no file gives.
    pub(crate) const USUAL: Self = Self {
        azimuth: 30.0,
        elevation: 15.0,
        distance: 1.0,
        fov: 45.0,
        target: DVec3::ZERO,
    };

    /// The default for a splat model: 30 degrees to the side, 15 above, a field of view of 45
    /// degrees, and a distance at which 95 % of the Gaussians are visible.
    #[must_use]
    pub fn around(cloud: &Cloud) -> Self {
        let mut middle = [0.0; 3];
        for (axis, m) in middle.iter_mut().enumerate() {
            let mut all: Vec<f32> = cloud.means().iter().map(|p| p[axis]).collect();
            let half = all.len() / 2;
            *m = match all.len() {
                0 => 0.0,
                _ => f64::from(*all.select_nth_unstable_by(half, f32::total_cmp).1),
            };
        }
        let target = DVec3::from(middle);
        let mut far: Vec<f64> = cloud
            .means()
            .iter()
            .map(|p| (dvec3(p[0].into(), p[1].into(), p[2].into()) - target).length())
            .collect();
        let place = (far.len() as f64 * FRAMED) as usize;
        let radius = match far.len() {
            0 => 1.0,
            n => {
                *far.select_nth_unstable_by(place.min(n - 1), f64::total_cmp)
                    .1
            }
        };
        Self {
            // At least what the near plane of the profiles leaves.
            distance: (radius / (Self::USUAL.fov / 2.0).to_radians().sin()).max(0.5),
            target,
            ..Self::USUAL
        }
    }

    /// The camera. `up` is the vertical axis.
    #[must_use]
    pub fn camera(&self, up: DVec3, width: u32, height: u32) -> Camera {
        let (sin, cos) = self.azimuth.to_radians().sin_cos();
        // Two horizontal axes, whichever axis is vertical.
        let ahead = if up.z.abs() > 0.5 { DVec3::Y } else { DVec3::Z };
        let side = up.cross(ahead);
        let lift = self.elevation.to_radians();
        let back = (side * sin - ahead * cos) * lift.cos() + up * lift.sin();
        let eye = self.target + back * self.distance;
        Camera::look_at(eye, self.target, up, self.fov.to_radians(), width, height)
    }
}

/// A camera rotated by `degrees` about the axis `up` through a point, in the direction in which
/// [`Orbit::azimuth`] grows.
pub(super) fn turned(camera: &Camera, about: DVec3, up: DVec3, degrees: f64) -> Camera {
    let turn = DAffine3::from_axis_angle(up, degrees.to_radians());
    let there = DAffine3::from_translation(about) * turn * DAffine3::from_translation(-about);
    Camera {
        world_to_camera: camera.world_to_camera * there,
        ..*camera
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn an_orbit_looks_at_its_target_from_its_distance() {
        for up in [DVec3::Y, DVec3::NEG_Y, DVec3::Z] {
            for azimuth in [0.0, 30.0, 200.0] {
                let orbit = Orbit {
                    azimuth,
                    elevation: 20.0,
                    distance: 3.0,
                    fov: 40.0,
                    target: dvec3(1.0, 2.0, 3.0),
                };
                let camera = orbit.camera(up, 80, 60);
                let seen = camera.world_to_camera.transform_point3(orbit.target);
                assert!((seen - dvec3(0.0, 0.0, 3.0)).length() < 1e-9, "{seen}");
                // Above the target, and upright.
                let height = (camera.position() - orbit.target).dot(up);
                assert!((height - 3.0 * 20f64.to_radians().sin()).abs() < 1e-9);
                let tip = camera.world_to_camera.transform_vector3(up);
                assert!(tip.y < 0.0 && tip.x.abs() < 1e-9, "{tip}");
                let further = Orbit {
                    azimuth: azimuth + 40.0,
                    ..orbit
                };
                let expected = further.camera(up, 80, 60).world_to_camera;
                let found = turned(&camera, orbit.target, up, 40.0).world_to_camera;
                assert!(found.abs_diff_eq(expected, 1e-9), "{found} {expected}");
            }
        }
    }

    #[test]
    fn the_default_frames_the_bulk_and_not_the_stragglers() {
        let mut means = vec![[5.0, 0.0, 0.0]; 99];
        for (i, m) in means.iter_mut().enumerate() {
            m[1] = (i as f32 - 49.0) / 50.0;
        }
        means.push([1e6, 0.0, 0.0]);
        let n = means.len();
        let cloud = Cloud::new(
            0,
            means,
            vec![[-3.0; 3]; n],
            vec![[1.0, 0.0, 0.0, 0.0]; n],
            vec![0.0; n],
            vec![[0.0; 3]; n],
        )
        .unwrap();
        let orbit = Orbit::around(&cloud);
        assert!((orbit.target - dvec3(5.0, 0.0, 0.0)).length() < 0.05);
        assert!(orbit.distance > 2.0 && orbit.distance < 4.0, "{orbit:?}");
    }
}
