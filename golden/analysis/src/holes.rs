//! Warped frames whose disoccluded pixels stay empty.

use glam::DVec3;

use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;
use potamoi_warp::{Renderer, Shaded, WarpError};

/// Wraps a renderer: whole frames are rendered, masked ones are not, so that disoccluded pixels of
/// warped frames stay background.
pub struct Holes<'a>(pub &'a dyn Renderer);

impl Renderer for Holes<'_> {
    fn background(&self) -> [f32; 3] {
        self.0.background()
    }

    fn bounds(&self) -> Option<[DVec3; 2]> {
        self.0.bounds()
    }

    fn shade(&self, camera: &Camera, only: Option<&Mask>) -> Result<Shaded, WarpError> {
        if only.is_none() {
            return self.0.shade(camera, None);
        }
        let picture = Picture::filled(camera.width, camera.height, self.0.background());
        Ok(Shaded {
            depth: vec![f32::INFINITY; picture.rgb.len()],
            picture,
        })
    }
}
