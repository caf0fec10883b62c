//! Rendering at half the resolution (DS-2), the baseline of warping.

use image::imageops::{FilterType, resize};
use image::{ImageBuffer, Rgb};

use super::{Renderer, WarpError};
use potamoi_base::camera::Camera;
use potamoi_base::picture::Picture;

/// Renders at half the width and height, rounded up, and upscales the picture bilinearly.
///
/// # Errors
/// Those of the renderer.
pub fn half_resolution(renderer: &dyn Renderer, camera: &Camera) -> Result<Picture, WarpError> {
    let small = camera.resized(camera.width.div_ceil(2), camera.height.div_ceil(2));
    let picture = renderer.shade(&small, None)?.picture;
    let mut pixels = ImageBuffer::<Rgb<f32>, Vec<f32>>::new(small.width, small.height);
    // Scaling holds floats to 0..1.
    let peak = picture.rgb.iter().flatten().fold(1f32, |m, v| m.max(*v));
    for (to, from) in pixels.pixels_mut().zip(&picture.rgb) {
        *to = Rgb(from.map(|v| v / peak));
    }
    let large = resize(&pixels, camera.width, camera.height, FilterType::Triangle);
    Ok(Picture {
        width: camera.width,
        height: camera.height,
        rgb: large.pixels().map(|p| p.0.map(|v| v * peak)).collect(),
    })
}
