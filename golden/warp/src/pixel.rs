//! Pixel coordinates.

use glam::DVec2;
use potamoi_base::camera::Camera;

/// The centre of a pixel.
pub(crate) fn centre(camera: &Camera, pixel: usize) -> DVec2 {
    let [x, y] = [pixel as u32 % camera.width, pixel as u32 / camera.width];
    DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)
}
