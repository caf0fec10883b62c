//! Sampling of a warped pixel's colour.

use glam::DVec2;

use rayon::prelude::*;

use super::Shaded;
use super::classify::Rule;
use super::reproject::Transfer;
use super::sampling::Sampling;
use potamoi_base::camera::Camera;

/// Maximum relative depth difference of neighbours that count as one surface.
const SAME_SURFACE: f64 = 0.02;
/// A pixel is at an edge if its depth differs from the mean of two opposite neighbours by more
/// than this fraction: slopes do not, steps do.
const STEP: f64 = 0.02;
/// Minimum total weight of neighbours on the same surface.
const LEAST_WEIGHT: f64 = 0.25;

/// Whether two depths, the second of a surface, may belong to one surface.
pub(super) fn is_same_surface(a: f64, b: f64) -> bool {
    (a - b).abs() <= SAME_SURFACE * b
}

/// Samples colours of a reference.
pub(super) struct Sampler<'a> {
    reference: &'a Shaded,
    /// Transform from the target to the reference.
    back: Transfer,
    sampling: Sampling,
    /// For each reference pixel, whether it is at an edge; `None` if edges do not matter.
    edges: Option<Vec<bool>>,
}

impl<'a> Sampler<'a> {
    pub(super) fn new(reference: &'a Shaded, from: &Camera, to: &Camera, rule: &Rule) -> Self {
        Self {
            reference,
            back: Transfer::new(to, from),
            sampling: rule.sampling,
            edges: rule.render_edges.then(|| edges(reference)),
        }
    }

    /// Whether a target pixel, as in [`Sampler::colour`], shows an edge of the reference, if edges
    /// matter. Such pixels mix foreground and background, which separate as the camera moves.
    pub(super) fn is_at_edge(&self, at: DVec2, depth: f64, source: u32) -> bool {
        let Some(edges) = &self.edges else {
            return false;
        };
        let around = self.around(at, depth).map(|(around, _)| around);
        edges[source as usize] || around.is_some_and(|all| all.iter().any(|(p, _)| edges[*p]))
    }

    /// The reference pixel that best shows the surface of a target pixel at `depth`; `None` unless
    /// all pixels around the position show that surface.
    pub(super) fn sees(&self, at: DVec2, depth: f64) -> Option<u32> {
        let (around, depth) = self.around(at, depth)?;
        let all = around
            .iter()
            .all(|(p, _)| is_same_surface(self.reference.depth[*p].into(), depth));
        let best = around.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        all.then_some(best.0 as u32)
    }

    /// The colour of a target pixel with centre `at` that shows a surface at `depth`, to which the
    /// reference pixel `source` was warped.
    pub(super) fn colour(&self, at: DVec2, depth: f64, source: u32) -> [f32; 3] {
        let nearest = self.reference.picture.rgb[source as usize];
        match self.sampling {
            Sampling::Nearest => nearest,
            Sampling::Bilinear => self.between(at, depth).unwrap_or(nearest),
        }
    }

    /// The four pixels around the position of a point in the reference, their weights, and the
    /// point's depth there; `None` if they are not all in the picture.
    fn around(&self, at: DVec2, depth: f64) -> Option<([(usize, f64); 4], f64)> {
        let point = self.back.point(at, depth);
        if point.z <= 0.0 || point.is_nan() {
            return None;
        }
        let picture = &self.reference.picture;
        let place = self.back.project(point) - 0.5;
        let low = place.floor();
        let last = DVec2::new(f64::from(picture.width), f64::from(picture.height)) - 1.0;
        if !(low.cmpge(DVec2::ZERO).all() && low.cmplt(last).all()) {
            return None;
        }
        let [fx, fy] = (place - low).to_array();
        let width = picture.width as usize;
        let first = low.y as usize * width + low.x as usize;
        let around = [
            (first, (1.0 - fx) * (1.0 - fy)),
            (first + 1, fx * (1.0 - fy)),
            (first + width, (1.0 - fx) * fy),
            (first + width + 1, fx * fy),
        ];
        Some((around, point.z))
    }

    fn between(&self, at: DVec2, depth: f64) -> Option<[f32; 3]> {
        let (around, depth) = self.around(at, depth)?;
        let (mut sum, mut total) = ([0.0; 3], 0.0);
        for (pixel, weight) in around {
            let there = f64::from(self.reference.depth[pixel]);
            if is_same_surface(there, depth) {
                total += weight;
                for (sum, value) in sum.iter_mut().zip(self.reference.picture.rgb[pixel]) {
                    *sum += weight * f64::from(value);
                }
            }
        }
        (total >= LEAST_WEIGHT).then(|| sum.map(|v| (v / total) as f32))
    }
}

/// Marks pixels next to a depth step or to void.
fn edges(reference: &Shaded) -> Vec<bool> {
    let (width, height) = (
        reference.picture.width as usize,
        reference.picture.height as usize,
    );
    let depth = |i: usize| f64::from(reference.depth[i]);
    let steps = |a: usize, i: usize, b: usize| {
        // Void, and what is not known, is not near anything.
        let off = (depth(a) + depth(b)) / 2.0 - depth(i);
        off.is_nan() || off.abs() > STEP * depth(i)
    };
    (0..width * height)
        .into_par_iter()
        .map(|i| {
            let (x, y) = (i % width, i / width);
            (x > 0 && x + 1 < width && steps(i - 1, i, i + 1))
                || (y > 0 && y + 1 < height && steps(i - width, i, i + width))
        })
        .collect()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{Profile, Rule, Warper};
    use crate::{Renderer, WarpError};
    use glam::DVec3;
    use potamoi_base::mask::Mask;
    use potamoi_base::picture::Picture;

    /// A wall with a smooth pattern at z = 0, seen from before it.
    struct Wall;

    fn pattern(x: f64, y: f64) -> [f32; 3] {
        let wave = |v: f64| (0.5 + 0.4 * v.sin()) as f32;
        [wave(9.0 * x), wave(7.0 * y + 2.0 * x), wave(5.0 * (x + y))]
    }

    impl Renderer for Wall {
        fn background(&self) -> [f32; 3] {
            [0.0; 3]
        }

        fn bounds(&self) -> Option<[DVec3; 2]> {
            None
        }

        fn shade(&self, camera: &Camera, _: Option<&Mask>) -> Result<Shaded, WarpError> {
            let hit = |i: u32| {
                let (origin, direction) = camera.ray(i % camera.width, i / camera.width);
                let distance = -origin.z / direction.z;
                (origin + direction * distance, distance * camera.slant(i))
            };
            let hits: Vec<_> = (0..camera.width * camera.height).map(hit).collect();
            Ok(Shaded {
                picture: Picture {
                    width: camera.width,
                    height: camera.height,
                    rgb: hits.iter().map(|(p, _)| pattern(p.x, p.y)).collect(),
                },
                depth: hits.iter().map(|(_, depth)| *depth as f32).collect(),
            })
        }
    }

    fn grey(width: u32, depth: Vec<f32>) -> Shaded {
        let height = depth.len() as u32 / width;
        let level = |i: usize| [i as f32 / 16.0; 3];
        Shaded {
            picture: Picture {
                width,
                height,
                rgb: (0..depth.len()).map(level).collect(),
            },
            depth,
        }
    }

    #[test]
    fn steps_of_depth_are_edges_and_slopes_are_not() {
        let at = |depths: [f32; 5]| edges(&grey(5, depths.to_vec()));
        // A step of 5 % is 2.5 % off the middle of both neighbours.
        assert_eq!(
            at([1.0, 1.0, 1.05, 1.05, 1.05]),
            [false, true, true, false, false]
        );
        assert_eq!(at([1.0, 1.0, 1.03, 1.03, 1.03]), [false; 5]);
        assert_eq!(at([1.0, 1.2, 1.4, 1.6, 1.8]), [false; 5]);
        let [void, unknown] = [f32::INFINITY, f32::NAN];
        assert!(at([1.0, 1.0, 1.0, void, void])[2]);
        assert!(at([1.0, 1.0, 1.0, unknown, 1.0])[2]);
    }

    /// Between two surfaces the colour is of the one that is shown, as long as a
    /// quarter of the weight is its.
    #[test]
    fn neighbours_of_another_surface_do_not_count() {
        let here = Camera {
            width: 4,
            height: 2,
            focal: DVec2::splat(4.0),
            centre: DVec2::new(2.0, 1.0),
            world_to_camera: glam::DAffine3::IDENTITY,
        };
        let reference = grey(4, [1.0, 1.0, 2.0, 2.0].repeat(2));
        let rule = Profile::Potamoi.rule();
        let sampler = Sampler::new(&reference, &here, &here, &rule);
        // Columns 1 and 2, the near surface left of the middle, rows 0 and 1 alike.
        for (part, expected) in [(0.4, 3.0), (0.7, 3.0), (0.8, 0.0)] {
            let at = DVec2::new(1.5 + part, 1.0);
            let found = f64::from(sampler.colour(at, 1.0, 0)[0]) * 16.0;
            assert!((found - expected).abs() < 1e-6, "{part}: {found}");
        }
        assert!(sampler.sees(DVec2::new(1.9, 1.0), 1.0).is_none());
        assert_eq!(sampler.sees(DVec2::new(1.2, 0.9), 1.0), Some(1));
    }

    #[test]
    fn bilinear_samples_are_where_the_centre_is_and_nearest_ones_are_not() {
        let from = |x: f64| {
            let eye = DVec3::new(x, 0.3, -3.0);
            Camera::look_at(eye, DVec3::new(0.1, 0.0, 0.0), DVec3::Y, 0.7, 120, 100)
        };
        let (here, there) = (from(0.0), from(0.213));
        let reference = Wall.shade(&here, None).unwrap();
        let truth = Wall.shade(&there, None).unwrap().picture;
        let psnr = |sampling| {
            let warper = Warper {
                renderer: &Wall,
                geometry: None,
                rule: Rule {
                    sampling,
                    ..Profile::Paper.rule()
                },
            };
            let target = warper.target(&reference, &here, &there).unwrap();
            let picture = target.shaded.picture;
            picture
                .psnr(&truth, |i| !target.classes[i].is_rendered())
                .unwrap()
        };
        let [nearest, bilinear] = [Sampling::Nearest, Sampling::Bilinear].map(psnr);
        // Half a pixel of the pattern's slope against its curvature over one.
        assert!(nearest < 40.0, "{nearest}");
        assert!(bilinear > nearest + 15.0, "{nearest} {bilinear}");
    }
}
