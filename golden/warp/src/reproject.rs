//! Steps 1 to 3 of a target frame: point cloud, transformation, re-projection
//! with a z-buffer.

use std::sync::atomic::{AtomicU64, Ordering};

use glam::{DMat3, DVec2, DVec3};
use rayon::prelude::*;

use super::{Shaded, is_surface};
use potamoi_base::camera::Camera;

/// Marks a pixel on which no point landed.
const NONE: u64 = u64::MAX;

/// Points of a reference frame, projected to a target camera.
#[derive(Debug, Clone, PartialEq)]
pub struct Warped {
    /// For each target pixel, the nearest point's reference pixel and its depth along the target
    /// camera's axis.
    points: Vec<Option<(u32, f32)>>,
}

impl Warped {
    /// The reference pixel and the depth of the point seen at a target pixel; `None` if none
    /// landed.
    #[must_use]
    pub fn at(&self, pixel: usize) -> Option<(u32, f32)> {
        self.points.get(pixel).copied().flatten()
    }
}

/// The transform from a pixel of one camera, with its depth, to a pixel of another.
pub(super) struct Transfer {
    /// The part that scales with depth: by column, by row, and constant.
    across: DVec3,
    down: DVec3,
    base: DVec3,
    /// The part that does not depend on depth.
    shift: DVec3,
    focal: DVec2,
    centre: DVec2,
}

impl Transfer {
    pub(super) fn new(from: &Camera, to: &Camera) -> Self {
        let between = to.world_to_camera * from.world_to_camera.inverse();
        let inverse = DMat3::from_cols(
            DVec3::X / from.focal.x,
            DVec3::Y / from.focal.y,
            DVec3::new(
                -from.centre.x / from.focal.x,
                -from.centre.y / from.focal.y,
                1.0,
            ),
        );
        let rays = between.matrix3 * inverse;
        Self {
            across: rays.x_axis,
            down: rays.y_axis,
            base: rays.z_axis,
            shift: between.translation,
            focal: to.focal,
            centre: to.centre,
        }
    }

    /// A point in the coordinates of the other camera.
    pub(super) fn point(&self, at: DVec2, depth: f64) -> DVec3 {
        (self.across * at.x + self.down * at.y + self.base) * depth + self.shift
    }

    /// The position in the other camera's picture of a point in front of it, in its coordinates.
    pub(super) fn project(&self, point: DVec3) -> DVec2 {
        point.truncate() / point.z * self.focal + self.centre
    }
}

/// Warps a reference frame to a target camera. Each reference pixel with a surface is a point at
/// the pixel's centre. It lands on the target pixel that contains it, and the nearest point wins;
/// among equal depths the first in the reference, row by row. Points on or behind the target
/// camera's plane, or too far for a depth, are dropped. The result does not depend on the number
/// of threads.
#[must_use]
pub fn reproject(reference: &Shaded, from: &Camera, to: &Camera) -> Warped {
    let transfer = Transfer::new(from, to);
    let size = DVec2::new(f64::from(to.width), f64::from(to.height));
    let count = to.width as usize * to.height as usize;
    let mut nearest: Vec<AtomicU64> = vec![];
    nearest.resize_with(count, || AtomicU64::new(NONE));
    let width = from.width as usize;
    reference
        .depth
        .par_chunks(width.max(1))
        .enumerate()
        .for_each(|(row, depths)| {
            let base = transfer.base + transfer.down * (row as f64 + 0.5);
            for (column, depth) in depths.iter().enumerate() {
                if !is_surface(*depth) {
                    continue;
                }
                let ray = base + transfer.across * (column as f64 + 0.5);
                let point = ray * f64::from(*depth) + transfer.shift;
                let near = point.z as f32;
                if !is_surface(near) {
                    continue;
                }
                let at = transfer.project(point);
                if !(at.x >= 0.0 && at.y >= 0.0 && at.x < size.x && at.y < size.y) {
                    continue;
                }
                let to_pixel = at.y as usize * to.width as usize + at.x as usize;
                // Bits of positive floats are in the order of their values.
                let key = u64::from(near.to_bits()) << 32 | (row * width + column) as u64;
                let cell = &nearest[to_pixel];
                if key < cell.load(Ordering::Relaxed) {
                    cell.fetch_min(key, Ordering::Relaxed);
                }
            }
        });
    let point = |cell: AtomicU64| match cell.into_inner() {
        NONE => None,
        key => Some((key as u32, f32::from_bits((key >> 32) as u32))),
    };
    Warped {
        points: nearest.into_iter().map(point).collect(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use glam::{DAffine3, DQuat};
    use potamoi_base::picture::Picture;
    use proptest::prelude::*;

    fn camera(width: u32, height: u32, pose: DAffine3) -> Camera {
        Camera {
            width,
            height,
            focal: DVec2::new(40.0, 42.0),
            centre: DVec2::new(f64::from(width), f64::from(height)) / 2.0,
            world_to_camera: pose,
        }
    }

    fn shaded(width: u32, height: u32, depth: Vec<f32>) -> Shaded {
        Shaded {
            picture: Picture::filled(width, height, [0.5; 3]),
            depth,
        }
    }

    /// The paper's three equations, point by point, in the order of a plain
    /// z-buffer.
    fn plain(reference: &Shaded, from: &Camera, to: &Camera) -> Vec<Option<(u32, f32)>> {
        let mut nearest: Vec<Option<(u32, f32)>> = vec![None; (to.width * to.height) as usize];
        for (i, depth) in reference.depth.iter().enumerate() {
            let depth = f64::from(*depth);
            if !(depth > 0.0 && depth.is_finite()) {
                continue;
            }
            let (x, y) = (i as u32 % from.width, i as u32 / from.width);
            let local = DVec3::new(
                depth / from.focal.x * (f64::from(x) + 0.5) - depth * from.centre.x / from.focal.x,
                depth / from.focal.y * (f64::from(y) + 0.5) - depth * from.centre.y / from.focal.y,
                depth,
            );
            let world = from.world_to_camera.inverse().transform_point3(local);
            let point = to.world_to_camera.transform_point3(world);
            if point.z as f32 <= 0.0 {
                continue;
            }
            let u = to.focal.x / point.z * point.x + to.centre.x;
            let v = to.focal.y / point.z * point.y + to.centre.y;
            let inside =
                (0.0..f64::from(to.width)).contains(&u) && (0.0..f64::from(to.height)).contains(&v);
            if inside {
                let cell = &mut nearest[v as usize * to.width as usize + u as usize];
                if cell.is_none_or(|(_, z)| (point.z as f32) < z) {
                    *cell = Some((i as u32, point.z as f32));
                }
            }
        }
        nearest
    }

    #[test]
    fn the_same_camera_gives_the_same_picture() {
        let turned = DAffine3::from_rotation_translation(
            DQuat::from_rotation_y(0.7),
            DVec3::new(1.0, -2.0, 3.0),
        );
        let here = camera(9, 7, turned);
        let depth: Vec<f32> = (0..63).map(|i| 0.5 + i as f32 / 7.0).collect();
        let warped = reproject(&shaded(9, 7, depth.clone()), &here, &here);
        for (i, depth) in depth.iter().enumerate() {
            let (from, z) = warped.at(i).unwrap();
            assert_eq!(from as usize, i);
            assert!((z - depth).abs() < 1e-5);
        }
    }

    #[test]
    fn what_is_no_surface_and_what_lies_behind_lands_nowhere() {
        let here = camera(4, 1, DAffine3::IDENTITY);
        let odd = shaded(4, 1, vec![0.0, f32::INFINITY, f32::NAN, -1.0]);
        assert!((0..4).all(|i| reproject(&odd, &here, &here).at(i).is_none()));
        // Half a turn, and a camera that has gone past the points.
        let flat = shaded(4, 1, vec![2.0; 4]);
        for pose in [
            DAffine3::from_rotation_y(std::f64::consts::PI),
            DAffine3::from_translation(DVec3::new(0.0, 0.0, -2.0)),
            DAffine3::from_translation(DVec3::new(0.0, 0.0, -2.5)),
            DAffine3::from_translation(DVec3::NAN),
        ] {
            let there = camera(4, 1, pose);
            assert!((0..4).all(|i| reproject(&flat, &here, &there).at(i).is_none()));
        }
    }

    #[test]
    fn of_equal_depths_the_first_stays() {
        // Two columns of a wide picture land on one of a narrow one.
        let wide = camera(8, 1, DAffine3::IDENTITY);
        let mut narrow = camera(4, 1, DAffine3::IDENTITY);
        narrow.focal /= 2.0;
        let warped = reproject(&shaded(8, 1, vec![3.0; 8]), &wide, &narrow);
        let found: Vec<u32> = (0..4).map(|i| warped.at(i).unwrap().0).collect();
        assert_eq!(found, [0, 2, 4, 6]);
    }

    proptest! {
        #[test]
        fn it_is_the_papers_equations(
            turn in -3.2f64..3.2, tilt in -1.0f64..1.0,
            shift in prop::array::uniform3(-2.0f64..2.0),
            depths in prop::collection::vec(0.05f32..8.0, 12 * 10),
        ) {
            let pose = DAffine3::from_rotation_translation(
                DQuat::from_rotation_y(turn * 0.1) * DQuat::from_rotation_x(tilt * 0.1),
                DVec3::from(shift) * 0.3,
            );
            let (from, to) = (camera(12, 10, DAffine3::IDENTITY), camera(11, 13, pose));
            let reference = shaded(12, 10, depths);
            let found = reproject(&reference, &from, &to);
            let expected = plain(&reference, &from, &to);
            // Rounding of a coordinate that lies on a pixel's edge may differ,
            // which moves one point of 120.
            let differ = (0..expected.len()).filter(|i| {
                match (found.at(*i), expected[*i]) {
                    (Some((a, z)), Some((b, w))) => a != b || (z - w).abs() > 1e-5 * w,
                    (None, None) => false,
                    _ => true,
                }
            });
            prop_assert!(differ.count() <= 1);
        }
    }
}
