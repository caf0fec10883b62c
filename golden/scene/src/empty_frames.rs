//! Detection of frames in which no part of the model is in view, since their pictures are only
//! background.

use glam::DVec3;
use rayon::prelude::*;

use super::{Kind, Scene};
use potamoi_base::camera::{Camera, crossing};
use potamoi_fields::Along;
use potamoi_splats as splats;

/// Maximum number of frames listed by number.
const TOLD: usize = 8;

impl Scene {
    /// A sentence if some camera has no part of the model in view, with the numbers of the frames
    /// if there are several.
    #[must_use]
    pub fn unseen(&self, cameras: &[Camera]) -> Option<String> {
        let frames: Vec<usize> = (cameras.iter().enumerate())
            .filter(|(_, camera)| !self.is_in_view(camera))
            .map(|(at, _)| at)
            .collect();
        if frames.is_empty() {
            return None;
        }
        let what = match self.model().kind() {
            Kind::Splats(cloud) => format!("0 of {} Gaussians", cloud.len()),
            Kind::Field(_) => "no ray meets the model".to_owned(),
        };
        let only = "the picture is background only";
        if cameras.len() == 1 {
            return Some(format!("nothing is in view ({what}): {only}"));
        }
        let told: Vec<String> = frames.iter().take(TOLD).map(usize::to_string).collect();
        let more = match frames.len().saturating_sub(TOLD) {
            0 => String::new(),
            more => format!(" and {more} more"),
        };
        Some(format!(
            "nothing is in view in {} of {} frames ({what}; frames {}{more}): {only}",
            frames.len(),
            cameras.len(),
            told.join(", ")
        ))
    }

    fn is_in_view(&self, camera: &Camera) -> bool {
        match self.model().kind() {
            // What cannot be projected is refused where it is rendered.
            Kind::Splats(cloud) => {
                splats::is_any_in_view(cloud, camera, self.profile()).unwrap_or(true)
            }
            Kind::Field(field) => {
                let sampling = field.sampling();
                meets(sampling.bounds, camera, sampling.range, sampling.along)
            }
        }
    }
}

/// Whether the ray through a pixel's centre meets a box within a range.
fn meets(bounds: [DVec3; 2], camera: &Camera, range: [f64; 2], along: Along) -> bool {
    if is_beside(bounds, camera) {
        return false;
    }
    let axis = camera.axis();
    let meets = |x: u32, y: u32| {
        let (origin, direction) = camera.ray(x, y);
        let slant = match along {
            Along::Axis => 1.0 / axis.dot(direction),
            Along::Ray => 1.0,
        };
        let range = range.map(|depth| depth * slant);
        let [near, far] = crossing(bounds, origin, direction, range);
        far >= near
    };
    let rows = (0..camera.height).into_par_iter();
    meets(camera.width / 2, camera.height / 2)
        || rows
            .into_par_iter()
            .any(|y| (0..camera.width).any(|x| meets(x, y)))
}

/// Whether a box lies outside one of a camera's side planes, so that no ray needs to be tested.
fn is_beside([low, high]: [DVec3; 2], camera: &Camera) -> bool {
    let corners = (0..8).map(|i| {
        let part = |bit: u32, axis: usize| match i >> bit & 1 {
            0 => low[axis],
            _ => high[axis],
        };
        let corner = DVec3::new(part(0, 0), part(1, 1), part(2, 2));
        camera.world_to_camera.transform_point3(corner)
    });
    let corners: Vec<DVec3> = corners.collect();
    let first = -camera.centre / camera.focal;
    let size = glam::DVec2::new(camera.width.into(), camera.height.into());
    let last = (size - camera.centre) / camera.focal;
    let beyond = |out: &dyn Fn(&DVec3) -> bool| corners.iter().all(out);
    beyond(&|p| p.z < 0.0)
        || beyond(&|p| p.x < first.x * p.z)
        || beyond(&|p| p.x > last.x * p.z)
        || beyond(&|p| p.y < first.y * p.z)
        || beyond(&|p| p.y > last.y * p.z)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use glam::DMat3;

    use super::*;

    /// The same place, turned about the vertical axis of the camera.
    fn turned(camera: &Camera, degrees: f64) -> Camera {
        let mut turned = *camera;
        let turn = DMat3::from_rotation_y(degrees.to_radians());
        turned.world_to_camera.matrix3 = turn * camera.world_to_camera.matrix3;
        turned.world_to_camera.translation = turn * camera.world_to_camera.translation;
        turned
    }

    #[test]
    fn frames_in_which_nothing_is_in_view_are_said_of_every_representation() {
        let fixtures = concat!(env!("CARGO_MANIFEST_DIR"), "/../tests/fixtures");
        for (representation, what) in [
            (&*format!("{fixtures}/splats/cloud.v2.spz"), "0 of "),
            (&format!("{fixtures}/ngp/cube.ingp"), "no ray"),
            ("lantern", "no ray"),
        ] {
            let mut scene = Scene::open(representation).unwrap();
            scene.set_size(Some(24), Some(16)).unwrap();
            let towards = *scene.camera();
            let [aside, away] = [90.0, 180.0].map(|degrees| turned(&towards, degrees));
            assert_eq!(scene.unseen(&[towards]), None, "{representation}");
            let paper = potamoi_formats::config::Config::paper();
            for camera in [aside, away] {
                scene.set_camera(camera);
                let said = scene.unseen(&[camera]).unwrap();
                assert!(
                    said.starts_with(&format!("nothing is in view ({what}")),
                    "{said}"
                );
                let of_files = scene.left_open_of_files();
                assert_eq!(
                    scene.left_open(),
                    [&of_files[..], std::slice::from_ref(&said)].concat()
                );
                assert_eq!(scene.not_checked(&paper).last(), Some(&said));
            }
            let rendered = scene.render_float().unwrap();
            assert!(!rendered.covered.contains(&true), "{representation}");
            let said = scene.unseen(&[towards, away, towards, aside]).unwrap();
            assert!(
                said.contains("in 2 of 4 frames") && said.contains("frames 1, 3"),
                "{said}"
            );
            let many = scene.unseen(&[away; 20]).unwrap();
            assert!(many.contains("6, 7 and 12 more"), "{many}");
        }
    }

    /// Gaussians in front of the camera that leave no colour are not in view.
    #[test]
    fn gaussians_that_are_too_clear_to_be_seen_are_not_in_view() {
        let folder = tempfile::tempdir().unwrap();
        let seen = |name: &str, opacity: u8| {
            let mut row = [0f32, 0.0, 1.0, 0.1, 0.1, 0.1]
                .map(f32::to_le_bytes)
                .concat();
            row.extend([200, 100, 50, opacity, 255, 128, 128, 128]);
            let path = folder.path().join(name);
            std::fs::write(&path, row).unwrap();
            let scene = Scene::open(path.to_str().unwrap()).unwrap();
            scene.unseen(&[*scene.camera()])
        };
        assert_eq!(seen("a.splat", 200), None);
        let said = seen("b.splat", 0).unwrap();
        assert!(said.contains("0 of 1 Gaussians"), "{said}");
    }

    /// A box at the edge of what is seen is looked at ray by ray.
    #[test]
    fn a_box_is_met_where_a_ray_of_a_pixel_goes_through_it() {
        let camera = Camera {
            width: 10,
            height: 10,
            focal: glam::DVec2::splat(10.0),
            centre: glam::DVec2::splat(5.0),
            world_to_camera: glam::DAffine3::IDENTITY,
        };
        let all = [0.0, f64::INFINITY];
        // The last rays go through x = 0.45 at z = 1.
        for (x, is_met) in [(0.44, true), (0.46, false), (0.51, false), (-0.6, true)] {
            let bounds = [DVec3::new(x, -0.1, 1.0), DVec3::new(x + 0.2, 0.1, 1.0)];
            assert_eq!(meets(bounds, &camera, all, Along::Ray), is_met, "{x}");
        }
        let ahead = [DVec3::splat(-0.1) + DVec3::Z, DVec3::splat(0.1) + DVec3::Z];
        assert!(meets(ahead, &camera, all, Along::Ray));
        assert!(!meets(ahead, &camera, [2.0, 6.0], Along::Axis));
        assert!(!meets(ahead.map(|p| -p), &camera, all, Along::Ray));
    }
}
