//! The void test for targets without known depth: empty space according to a reference frame.
//!
//! A ray of the target is a line in the reference's picture. If the reference sees nothing along
//! the part of it within the model's bounds, the ray meets no surface: all its points are on empty
//! rays of the reference (the visual hull of Laurentini, PAMI 1994).

use glam::{DVec2, DVec3};

use super::{Shaded, is_void};
use potamoi_base::camera::{Camera, crossing};

/// Empty space according to a reference frame.
#[derive(Debug)]
pub(super) struct Silhouette {
    camera: Camera,
    bounds: [DVec3; 2],
    /// For each pixel, the distance in pixels along the farther axis to the nearest pixel that
    /// sees something; 0 for such a pixel.
    away: Vec<u16>,
}

impl Silhouette {
    /// The silhouette of a model that lies within `bounds`.
    pub(super) fn new(reference: &Shaded, camera: &Camera, bounds: [DVec3; 2]) -> Self {
        let seen = |depth: &f32| if is_void(*depth) { u16::MAX } else { 0 };
        let mut away: Vec<u16> = reference.depth.iter().map(seen).collect();
        let (width, height) = (camera.width as usize, camera.height as usize);
        // Two passes find the distance by the farther axis exactly (Rosenfeld
        // and Pfaltz 1966).
        for y in 0..height {
            for x in 0..width {
                let before = [(-1, -1), (0, -1), (1, -1), (-1, 0)];
                relax(&mut away, [width, height], [x, y], before);
            }
        }
        for y in (0..height).rev() {
            for x in (0..width).rev() {
                let after = [(1, 1), (0, 1), (-1, 1), (1, 0)];
                relax(&mut away, [width, height], [x, y], after);
            }
        }
        Self {
            camera: *camera,
            bounds,
            away,
        }
    }

    /// Whether a ray from `origin` is known to be empty; `false` if the reference cannot decide.
    pub(super) fn is_void(&self, origin: DVec3, direction: DVec3) -> bool {
        if !(origin.is_finite() && direction.is_finite()) {
            return false;
        }
        let [near, far] = crossing(self.bounds, origin, direction, [0.0, f64::INFINITY]);
        if !(near <= far && far.is_finite()) {
            // Beside the bounds.
            return near > far;
        }
        let pose = self.camera.world_to_camera;
        let ends = [near, far].map(|t| pose.transform_point3(origin + direction * t));
        // The plane of the camera has no picture, nor has what lies behind.
        if !ends.iter().all(|p| p.z > 1e-6 * p.length()) {
            return false;
        }
        let [start, end] =
            ends.map(|p| p.truncate() / p.z * self.camera.focal + self.camera.centre);
        let length = (end - start).abs().max_element();
        let pace = (end - start) / length.max(1.0);
        let mut along = 0.0;
        loop {
            // Anything a pixel away counts, so that no corner is cut.
            let Some(away) = self.away(start + pace * along).filter(|away| *away > 1) else {
                return false;
            };
            if along >= length {
                return true;
            }
            along = (along + f64::from(away.max(3) - 2)).min(length);
        }
    }

    fn away(&self, at: DVec2) -> Option<u16> {
        let size = DVec2::new(f64::from(self.camera.width), f64::from(self.camera.height));
        if !(at.cmpge(DVec2::ZERO).all() && at.cmplt(size).all()) {
            return None;
        }
        let pixel = at.y as usize * self.camera.width as usize + at.x as usize;
        self.away.get(pixel).copied()
    }
}

/// Lowers the value of a pixel to at most one more than that of its nearest neighbour.
fn relax(
    away: &mut [u16],
    [width, height]: [usize; 2],
    [x, y]: [usize; 2],
    neighbours: [(isize, isize); 4],
) {
    let mut least = away[y * width + x];
    for (dx, dy) in neighbours {
        let (Some(nx), Some(ny)) = (x.checked_add_signed(dx), y.checked_add_signed(dy)) else {
            continue;
        };
        if nx < width && ny < height {
            least = least.min(away[ny * width + nx].saturating_add(1));
        }
    }
    away[y * width + x] = least;
}

#[cfg(test)]
mod tests {
    use super::*;
    use potamoi_base::picture::Picture;

    /// A ball of radius 0.5 at the origin, exactly.
    fn ball(camera: &Camera) -> Shaded {
        let pixels = camera.width * camera.height;
        let depth = (0..pixels).map(|i| {
            let (origin, direction) = camera.ray(i % camera.width, i / camera.width);
            let middle = -origin.dot(direction);
            let squared = 0.25 - (origin.length_squared() - middle * middle);
            if squared < 0.0 {
                f32::INFINITY
            } else {
                ((middle - squared.sqrt()) * camera.slant(i)) as f32
            }
        });
        Shaded {
            depth: depth.collect(),
            picture: Picture::filled(camera.width, camera.height, [0.0; 3]),
        }
    }

    fn from(azimuth: f64) -> Camera {
        let eye = 4.0 * DVec3::new(azimuth.sin(), 0.2, -azimuth.cos());
        Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.5, 64, 48)
    }

    #[test]
    fn it_never_calls_a_surface_void_and_finds_most_of_the_void() {
        let bounds = [DVec3::splat(-0.6), DVec3::splat(0.6)];
        for turn in [0.0, 0.02, 0.1, 0.5, 1.5, 3.1] {
            let (reference, target) = (from(0.0), from(turn));
            let silhouette = Silhouette::new(&ball(&reference), &reference, bounds);
            let truth = ball(&target);
            let (mut void, mut found) = (0, 0);
            for (i, depth) in (0..).zip(&truth.depth) {
                let (origin, direction) = target.ray(i % target.width, i / target.width);
                let says = silhouette.is_void(origin, direction);
                assert!(!says || is_void(*depth), "turn {turn}, pixel {i}");
                void += usize::from(is_void(*depth));
                found += usize::from(says);
            }
            assert!(
                found * 10 > void * 9 || turn > 0.2,
                "{turn}: {found} of {void}"
            );
            assert!(found * 2 > void, "{turn}: {found} of {void}");
        }
    }

    #[test]
    fn what_the_reference_does_not_see_is_not_called_void() {
        let bounds = [DVec3::splat(-0.6), DVec3::splat(0.6)];
        let camera = from(0.0);
        let empty = Shaded {
            depth: vec![f32::INFINITY; 64 * 48],
            picture: Picture::filled(64, 48, [0.0; 3]),
        };
        let silhouette = Silhouette::new(&empty, &camera, bounds);
        let ahead = DVec3::Z;
        assert!(silhouette.is_void(DVec3::new(0.0, 0.0, -4.0), ahead));
        // Beside the bounds; not a number.
        assert!(silhouette.is_void(DVec3::new(0.0, 7.0, -4.0), ahead));
        assert!(!silhouette.is_void(DVec3::NAN, ahead));
        // Within bounds that reach behind the reference, or out of its picture.
        let wide = [DVec3::splat(-9.0), DVec3::splat(9.0)];
        let silhouette = Silhouette::new(&empty, &camera, wide);
        assert!(!silhouette.is_void(DVec3::new(0.0, 0.0, -4.0), ahead));
        assert!(!silhouette.is_void(DVec3::new(-9.0, 0.0, 2.0), DVec3::X));
    }
}
