//! Exact depth of analytic scenes.

use potamoi_analytic::Analytic;
use potamoi_base::camera::Camera;
use potamoi_warp::{Geometry, WarpError};

/// Depth at which the transmittance of a camera's rays through an analytic field falls to one
/// half; void for rays that keep more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ExactDepth(pub Analytic);

impl Geometry for ExactDepth {
    fn depth(&self, camera: &Camera) -> Result<Vec<f32>, WarpError> {
        let truth = self.0.truth(camera, self.0.background());
        let along = (0..).zip(truth.distance);
        Ok(along
            .map(|(pixel, distance)| (distance * camera.slant(pixel)) as f32)
            .collect())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use potamoi_warp::{is_surface, is_void};

    #[test]
    fn it_lies_where_the_density_begins_to_stop_light() {
        let scene = Analytic::Cairn;
        let camera = scene.camera(0.4, 40, 30);
        let depth = ExactDepth(scene).depth(&camera).unwrap();
        assert_eq!(depth.len(), 1200);
        let mut surfaces = 0;
        for (i, depth) in (0..).zip(depth) {
            if is_void(depth) {
                continue;
            }
            assert!(is_surface(depth));
            surfaces += 1;
            let (origin, direction) = camera.ray(i % 40, i / 40);
            let at = |depth: f64| origin + direction * (depth / camera.slant(i));
            let voxel = scene.voxel();
            assert!(scene.density(at(f64::from(depth))) > 0.3 / voxel);
            // The rays come from outside.
            assert_eq!(scene.density(at(f64::from(depth) - 8.0 * voxel)), 0.0);
        }
        assert!((200..1100).contains(&surfaces), "{surfaces}");
    }
}
