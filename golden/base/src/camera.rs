//! Pinhole cameras.

use glam::{DAffine3, DMat3, DVec2, DVec3};

/// A pinhole camera in the OpenCV convention: x right, y down, looking along
/// +z. Pixel centres lie at integer + 0.5.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Camera {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Focal lengths in pixels.
    pub focal: DVec2,
    /// Principal point in pixels.
    pub centre: DVec2,
    /// World-to-camera transform, rigid.
    pub world_to_camera: DAffine3,
}

/// The interval in which a ray from `origin` along `direction` is within the box between two
/// corners and within `range`, in lengths of `direction`. If it is empty, the first number is
/// above the second.
#[must_use]
pub fn crossing(
    [low, high]: [DVec3; 2],
    origin: DVec3,
    direction: DVec3,
    [mut near, mut far]: [f64; 2],
) -> [f64; 2] {
    for axis in 0..3 {
        let (o, d) = (origin[axis], direction[axis]);
        let (low, high) = (low[axis], high[axis]);
        if d == 0.0 {
            // Parallel to these faces: inside all along, or never. Dividing
            // would give 0 / 0 for a ray in a face.
            if !(low..=high).contains(&o) {
                far = f64::NEG_INFINITY;
            }
            continue;
        }
        let (a, b) = ((low - o) / d, (high - o) / d);
        near = near.max(a.min(b));
        far = far.min(a.max(b));
    }
    [near, far]
}

impl Camera {
    /// A camera at `eye` that looks at `target`, with the vertical field of view in radians. `up`
    /// points up on screen and must not be parallel to the viewing direction.
    #[must_use]
    pub fn look_at(
        eye: DVec3,
        target: DVec3,
        up: DVec3,
        fov_y: f64,
        width: u32,
        height: u32,
    ) -> Self {
        let forward = (target - eye).normalize();
        let right = forward.cross(up).normalize();
        let down = forward.cross(right);
        let rotation = DMat3::from_cols(right, down, forward).transpose();
        let focal = f64::from(height) / 2.0 / (fov_y / 2.0).tan();
        Self {
            width,
            height,
            focal: DVec2::splat(focal),
            centre: DVec2::new(f64::from(width), f64::from(height)) / 2.0,
            world_to_camera: DAffine3::from_mat3_translation(rotation, rotation * -eye),
        }
    }

    /// Position in world coordinates.
    #[must_use]
    pub fn position(&self) -> DVec3 {
        self.world_to_camera.inverse().translation
    }

    /// Unit viewing direction in world coordinates.
    #[must_use]
    pub fn axis(&self) -> DVec3 {
        self.world_to_camera.matrix3.row(2)
    }

    /// Depth along the camera's axis per unit of distance along the ray of a pixel. Pixels are
    /// numbered row by row from the top left.
    #[must_use]
    pub fn slant(&self, pixel: u32) -> f64 {
        let (_, direction) = self.ray(pixel % self.width, pixel / self.width);
        self.axis().dot(direction)
    }

    /// The same view with another picture size; focal lengths and principal point are scaled.
    #[must_use]
    pub fn resized(&self, width: u32, height: u32) -> Self {
        let scale = DVec2::new(
            f64::from(width) / f64::from(self.width),
            f64::from(height) / f64::from(self.height),
        );
        Self {
            width,
            height,
            focal: self.focal * scale,
            centre: self.centre * scale,
            world_to_camera: self.world_to_camera,
        }
    }

    /// Origin and unit direction, in world coordinates, of the ray through the centre of pixel
    /// (`x`, `y`).
    #[must_use]
    pub fn ray(&self, x: u32, y: u32) -> (DVec3, DVec3) {
        let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        let local = ((pixel - self.centre) / self.focal).extend(1.0);
        let to_world = self.world_to_camera.inverse();
        let direction = (to_world.matrix3 * local).normalize();
        (to_world.translation, direction)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn a_ray_is_in_a_box_from_where_it_enters_to_where_it_leaves() {
        let bounds = [DVec3::ZERO, DVec3::new(4.0, 2.0, 2.0)];
        let all = [0.0, f64::INFINITY];
        let middle = DVec3::new(-2.0, 1.0, 1.0);
        assert_eq!(crossing(bounds, middle, DVec3::X, all), [2.0, 6.0]);
        assert_eq!(crossing(bounds, middle, DVec3::X, [3.0, 5.0]), [3.0, 5.0]);
        // From within; along a face; beside it; away from it.
        let [near, far] = crossing(bounds, DVec3::ONE, DVec3::NEG_X, all);
        assert_eq!([near, far], [0.0, 1.0]);
        let on = DVec3::new(-2.0, 0.0, 2.0);
        assert_eq!(crossing(bounds, on, DVec3::X, all), [2.0, 6.0]);
        for (from, to) in [
            (DVec3::new(-2.0, 3.0, 1.0), DVec3::X),
            (middle, DVec3::NEG_X),
        ] {
            let [near, far] = crossing(bounds, from, to, all);
            assert!(near > far, "{near} {far}");
        }
    }

    #[test]
    fn looking_along_z_keeps_the_axes() {
        let c = Camera::look_at(DVec3::ZERO, DVec3::Z, DVec3::NEG_Y, 1.0, 200, 100);
        let p = c
            .world_to_camera
            .transform_point3(DVec3::new(1.0, 2.0, 3.0));
        assert!((p - DVec3::new(1.0, 2.0, 3.0)).length() < 1e-12, "{p}");
    }

    #[test]
    fn the_ray_of_a_pixel_projects_back_onto_it() {
        let c = Camera::look_at(
            DVec3::new(3.0, -2.0, 1.0),
            DVec3::new(0.1, 0.2, 0.3),
            DVec3::NEG_Y,
            0.8,
            320,
            240,
        )
        .resized(640, 480);
        let (origin, direction) = c.ray(17, 401);
        let p = c.world_to_camera.transform_point3(origin + direction * 4.2);
        let pixel = p.truncate() / p.z * c.focal + c.centre;
        assert!((pixel - DVec2::new(17.5, 401.5)).length() < 1e-9, "{pixel}");
        assert!((c.position() - origin).length() < 1e-12);
    }
}
