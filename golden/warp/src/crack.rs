//! Cracks: target pixels on which no point of a surface landed although the reference shows the
//! surface all around. Points of neighbouring pixels diverge if a surface approaches or turns
//! towards the camera.

use super::reproject::Warped;
use super::sampler::Sampler;
use super::{is_surface, sampler};
use potamoi_base::camera::Camera;

/// One of two opposite neighbours of a pixel, as offsets; the other has the negated offsets.
const ACROSS: [[isize; 2]; 4] = [[-1, 0], [0, -1], [-1, -1], [1, -1]];

/// Detection and filling of cracks.
pub(super) struct Cracks<'a> {
    pub(super) warped: &'a Warped,
    pub(super) sampler: &'a Sampler<'a>,
    pub(super) to: &'a Camera,
    /// Fraction of a surface's depth below which another surface is in front of it.
    pub(super) nearer: f64,
}

impl Cracks<'_> {
    /// For a pixel in a crack, the reference pixel that shows its surface best, and its depth.
    /// `known` is the pixel's depth, if known; otherwise the mean of two opposite neighbours on
    /// one surface is used. `None` if a point landed that is not behind the surface, or if the
    /// reference does not show the surface all around.
    pub(super) fn fill(&self, pixel: usize, known: Option<f32>) -> Option<(u32, f32)> {
        let depth = match known {
            Some(known) => is_surface(known).then_some(known)?,
            None => self.between_neighbours(pixel)?,
        };
        if let Some((_, landed)) = self.warped.at(pixel)
            && f64::from(depth) >= self.nearer * f64::from(landed)
        {
            return None;
        }
        let at = super::pixel::centre(self.to, pixel);
        Some((self.sampler.sees(at, depth.into())?, depth))
    }

    /// The smallest mean depth of opposite neighbours that show one surface.
    fn between_neighbours(&self, pixel: usize) -> Option<f32> {
        let [width, height] = [self.to.width as isize, self.to.height as isize];
        let (x, y) = (pixel as isize % width, pixel as isize / width);
        let landed = |x: isize, y: isize| {
            let inside = (0..width).contains(&x) && (0..height).contains(&y);
            let at = inside.then_some((y * width + x) as usize)?;
            self.warped.at(at).map(|(_, depth)| depth)
        };
        let middle = |[dx, dy]: [isize; 2]| {
            let (a, b) = (landed(x + dx, y + dy)?, landed(x - dx, y - dy)?);
            sampler::is_same_surface(a.into(), b.into()).then_some((a + b) / 2.0)
        };
        ACROSS.into_iter().filter_map(middle).min_by(f32::total_cmp)
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::{Class, Geometry, Profile, Renderer, Rule, Shaded, WarpError, Warper};
    use glam::{DAffine3, DVec2, DVec3};
    use potamoi_base::mask::Mask;
    use potamoi_base::picture::Picture;

    /// A wall 2 before the origin with a square hole, and one at 4.
    struct Walls;

    impl Walls {
        fn hit(camera: &Camera, i: u32) -> (f64, [f32; 3]) {
            let (origin, towards) = camera.ray(i % camera.width, i / camera.width);
            let [near, far] = [2.0, 4.0].map(|z| (z - origin.z) / towards.z);
            let at = origin + towards * near;
            let hole = at.x.abs() < 0.2 && at.y.abs() < 0.2;
            match hole {
                false => (near * camera.slant(i), [0.8, 0.1, 0.1]),
                true => (far * camera.slant(i), [0.1, 0.1, 0.8]),
            }
        }
    }

    impl Renderer for Walls {
        fn background(&self) -> [f32; 3] {
            [0.0; 3]
        }

        fn bounds(&self) -> Option<[DVec3; 2]> {
            None
        }

        fn shade(&self, camera: &Camera, _: Option<&Mask>) -> Result<Shaded, WarpError> {
            let count = camera.width * camera.height;
            let hits: Vec<_> = (0..count).map(|i| Self::hit(camera, i)).collect();
            Ok(Shaded {
                picture: Picture {
                    width: camera.width,
                    height: camera.height,
                    rgb: hits.iter().map(|h| h.1).collect(),
                },
                depth: hits.iter().map(|h| h.0 as f32).collect(),
            })
        }
    }

    impl Geometry for Walls {
        fn depth(&self, camera: &Camera) -> Result<Vec<f32>, WarpError> {
            Ok(self.shade(camera, None)?.depth)
        }
    }

    /// Going ahead parts the points of the walls; what shows through the cracks
    /// of the first is not taken, and its hole stays.
    #[test]
    fn cracks_are_filled_and_holes_are_not() {
        let camera = |z: f64| Camera {
            width: 61,
            height: 61,
            focal: DVec2::splat(60.0),
            centre: DVec2::splat(30.5),
            world_to_camera: DAffine3::from_translation(DVec3::new(0.013, 0.007, -z)),
        };
        let (from, to) = (camera(0.0), camera(0.35));
        let reference = Walls.shade(&from, None).unwrap();
        let truth = Walls.shade(&to, None).unwrap();
        for geometry in [None, Some(&Walls as &dyn Geometry)] {
            let run = |fill_cracks| {
                let warper = Warper {
                    renderer: &Walls,
                    geometry,
                    rule: Rule {
                        fill_cracks,
                        ..Profile::Paper.rule()
                    },
                };
                let target = warper.target(&reference, &from, &to).unwrap();
                let rendered = target.classes.iter().filter(|c| c.is_rendered()).count();
                let wrong = (0..target.classes.len()).filter(|i| {
                    let off = target.shaded.picture.rgb[*i][0] - truth.picture.rgb[*i][0];
                    off.abs() > 0.1 && target.classes[*i] == Class::Warped
                });
                (rendered, wrong.count())
            };
            let [(plain, before), (filled, wrong)] = [false, true].map(run);
            // A fifth of the rows and of the columns have no point; of the filled
            // picture only what lies about the hole is left.
            assert!(plain > 700 && filled < 200, "{plain} {filled}");
            assert!(wrong <= before && wrong <= 40, "{before} {wrong}");
        }
    }
}
