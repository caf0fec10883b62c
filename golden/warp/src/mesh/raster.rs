//! Rasterisation of depth at the centres of pixels.
//!
//! A ray along (x, y, 1) meets a triangle if it is on the inner side of the three planes through
//! the triangle's edges and the camera (Olano and Greer 1997). So nothing has to be clipped, even
//! if a triangle crosses the camera's plane. The plane of an edge that two triangles share is the
//! same for both, to the last bit except for its sign, so no ray passes between them.

use std::sync::atomic::{AtomicU32, Ordering};

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::Mesh;
use potamoi_base::camera::Camera;

/// Triangles that one thread processes at a time.
const CHUNK: usize = 1 << 10;
/// Number of pixels in a triangle's box from which on its rows are drawn by all threads.
const LARGE: usize = 1 << 16;
/// Number of pixels in a row from which on it pays to compute the triangle's extent in it.
const WIDE: u32 = 8;

/// Distance from the camera, relative to a triangle's size, below which projection is inaccurate.
const NEAR: f64 = 1e-6;

/// The depth buffer: bits of positive floats are ordered like their values.
type Depths = [AtomicU32];

pub(super) fn depth(mesh: &Mesh, camera: &Camera) -> Vec<f32> {
    let count = camera.width as usize * camera.height as usize;
    let mut depths: Vec<AtomicU32> = vec![];
    depths.resize_with(count, || AtomicU32::new(f32::INFINITY.to_bits()));
    if count > 0 {
        let pose = camera.world_to_camera;
        let vertices: Vec<DVec3> = mesh
            .vertices
            .par_iter()
            .map(|v| pose.transform_point3(DVec3::from(v.map(f64::from))))
            .collect();
        let view = View::new(camera);
        mesh.triangles.par_chunks(CHUNK).for_each(|triangles| {
            for t in triangles {
                view.draw(t.map(|v| vertices[v as usize]), &depths);
            }
        });
    }
    let depths = depths.into_iter();
    depths.map(|d| f32::from_bits(d.into_inner())).collect()
}

/// A linear function of a pixel's position: slopes along x and y, and the value at the centre.
#[derive(Clone, Copy)]
struct Plane([f64; 3]);

impl Plane {
    /// The dot product of a vector, in camera coordinates, with the ray of a pixel.
    fn new(normal: DVec3, focal: DVec2) -> Self {
        Self([normal.x / focal.x, normal.y / focal.y, normal.z])
    }

    /// The sign flips exactly with that of the vector.
    fn at(self, x: f64, row: f64) -> f64 {
        self.0[0] * x + row
    }

    fn row(self, y: f64) -> f64 {
        self.0[1] * y + self.0[2]
    }
}

struct View {
    width: u32,
    height: u32,
    focal: DVec2,
    /// Centre of the first pixel, relative to the principal point.
    first: DVec2,
    /// Inward normals of the planes around the picture, widened by one pixel.
    sides: [DVec3; 4],
}

impl View {
    fn new(camera: &Camera) -> Self {
        let first = DVec2::splat(0.5) - camera.centre;
        let size = DVec2::new(f64::from(camera.width), f64::from(camera.height));
        let low = (first - 1.0) / camera.focal;
        let high = (first + size) / camera.focal;
        let (low, high) = (low.min(high), low.max(high));
        Self {
            width: camera.width,
            height: camera.height,
            focal: camera.focal,
            first,
            sides: [
                DVec3::new(1.0, 0.0, -low.x),
                DVec3::new(-1.0, 0.0, high.x),
                DVec3::new(0.0, 1.0, -low.y),
                DVec3::new(0.0, -1.0, high.y),
            ],
        }
    }

    /// First and last column, and first and last row, of the pixels that a triangle may cover.
    fn extent(&self, corners: [DVec3; 3]) -> Option<[[u32; 2]; 2]> {
        if corners.iter().all(|p| p.z <= 0.0) {
            return None;
        }
        let outside = |side: &DVec3| corners.iter().all(|p| side.dot(*p) < 0.0);
        if self.sides.iter().any(outside) {
            return None;
        }
        let mut low = DVec2::INFINITY;
        let mut high = DVec2::NEG_INFINITY;
        if corners.iter().all(|p| p.z > 0.0) {
            for p in corners {
                let at = p.truncate() / p.z * self.focal - self.first;
                low = low.min(at);
                high = high.max(at);
            }
        } else {
            let size = corners.iter().map(|p| p.abs().max_element());
            let near = NEAR * size.fold(0.0, f64::max);
            for p in self.seen_of(corners) {
                if p.z > near {
                    let at = p.truncate() / p.z * self.focal - self.first;
                    low = low.min(at);
                    high = high.max(at);
                } else {
                    // Its place is lost in rounding.
                    (low, high) = (DVec2::NEG_INFINITY, DVec2::INFINITY);
                }
            }
        }
        let span = |low: f64, high: f64, count: u32| {
            // A pixel more, for the rounding; casts hold to the range.
            let first = (low - 1.0).ceil().max(0.0) as u32;
            let last = (high + 1.0).floor().min(f64::from(count - 1));
            (last >= 0.0 && f64::from(first) <= last).then_some([first, last as u32])
        };
        Some([
            span(low.x, high.x, self.width)?,
            span(low.y, high.y, self.height)?,
        ])
    }

    /// Corners of the visible part of a triangle (Sutherland and Hodgman 1974), all of which are
    /// in front of the camera.
    fn seen_of(&self, corners: [DVec3; 3]) -> Vec<DVec3> {
        let mut around = corners.to_vec();
        for side in self.sides {
            let mut kept = Vec::with_capacity(around.len() + 1);
            for (i, p) in around.iter().enumerate() {
                let q = around[(i + 1) % around.len()];
                let (a, b) = (side.dot(*p), side.dot(q));
                if a >= 0.0 {
                    kept.push(*p);
                }
                if (a >= 0.0) != (b >= 0.0) {
                    kept.push(p.lerp(q, a / (a - b)));
                }
            }
            around = kept;
        }
        around
    }

    fn draw(&self, corners: [DVec3; 3], depths: &Depths) {
        let Some([columns, rows]) = self.extent(corners) else {
            return;
        };
        // Differences from the nearest corner keep most bits.
        let far = |p: DVec3| p.length_squared();
        let [a, b, c] = corners;
        let [a, b, c] = if far(a) <= far(b) && far(a) <= far(c) {
            [a, b, c]
        } else if far(b) <= far(c) {
            [b, c, a]
        } else {
            [c, a, b]
        };
        let normal = (b - a).cross(c - a);
        let away = a.dot(normal);
        // Edge-on, without area, or not a number.
        if away == 0.0 || !away.is_finite() {
            return;
        }
        let sign = away.signum();
        let inner = |from: DVec3, to: DVec3| Plane::new(from.cross(to) * sign, self.focal);
        let triangle = Triangle {
            sides: [inner(a, b), inner(b, c), inner(c, a)],
            face: Plane::new(normal, self.focal),
            away,
            range: [a.z.min(b.z).min(c.z), a.z.max(b.z).max(c.z)],
        };
        let width = self.width as usize;
        let draw = |y: u32| {
            let row = &depths[y as usize * width..][..width];
            triangle.draw_row(columns, self.first.x, self.first.y + f64::from(y), row);
        };
        let [from, to] = rows;
        let box_size = (to - from + 1) as usize * (columns[1] - columns[0] + 1) as usize;
        if box_size < LARGE {
            (from..=to).for_each(draw);
        } else {
            (from..=to).into_par_iter().for_each(draw);
        }
    }
}

struct Triangle {
    /// Functions that are at least 0 within the triangle.
    sides: [Plane; 3],
    /// Dot products with the normal: of a ray, and of the vertices.
    face: Plane,
    away: f64,
    /// Nearest and farthest depth.
    range: [f64; 2],
}

impl Triangle {
    /// Draws some columns of a row; `x` is the position of its first pixel.
    fn draw_row(&self, columns: [u32; 2], x: f64, y: f64, row: &Depths) {
        let sides = self.sides.map(|side| side.row(y));
        let [mut first, mut last] = columns;
        if last - first >= WIDE {
            for (side, base) in self.sides.iter().zip(sides) {
                // A pixel more, for the rounding; casts hold to the range.
                let slope = side.0[0];
                let passes = -base / slope - x;
                if slope > 0.0 {
                    first = first.max((passes - 1.0).max(0.0) as u32);
                } else if slope < 0.0 {
                    if passes + 1.0 < 0.0 {
                        return;
                    }
                    last = last.min((passes + 1.0) as u32);
                }
            }
        }
        let face = self.face.row(y);
        for column in first..=last.min(columns[1]) {
            let at = x + f64::from(column);
            if (0..3).any(|k| self.sides[k].at(at, sides[k]) < 0.0) {
                continue;
            }
            let depth = self.away / self.face.at(at, face);
            // Nearly edge-on, or not a number.
            if depth.is_nan() || depth <= 0.0 {
                continue;
            }
            let depth = depth.clamp(self.range[0], self.range[1]) as f32;
            // Nearer than a float can tell is not "not known".
            let bits = depth.max(f32::MIN_POSITIVE).to_bits();
            let cell = &row[column as usize];
            if bits < cell.load(Ordering::Relaxed) {
                cell.fetch_min(bits, Ordering::Relaxed);
            }
        }
    }
}
