//! Names of frames.

use potamoi_base::camera::Camera;
use potamoi_scene::Scene;

/// A scene and its size, such as `garden 64 x 64`; a file without its folder.
pub(crate) fn of_scene(scene: &Scene) -> String {
    of(scene.name(), scene.camera())
}

/// As [`of_scene`], of what a camera sees.
pub(crate) fn of(name: &str, camera: &Camera) -> String {
    let name = name.rsplit('/').next().unwrap_or(name);
    format!("{name} {} x {}", camera.width, camera.height)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_named_without_its_folder() {
        let camera = potamoi_scene::garden::camera();
        assert_eq!(of("models/a.ply", &camera), "a.ply 400 x 400");
        assert_eq!(of("cairn:ngp", &camera), "cairn:ngp 400 x 400");
    }
}
