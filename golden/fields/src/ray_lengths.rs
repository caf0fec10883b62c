//! The gathered samples of a frame, found once: up to where each ray stops, and where the field is
//! not known to be empty.

use glam::DVec3;
use rayon::prelude::*;

use super::float::{check, check_mask};
use super::ray_tile::{RayTile, tiles};
use super::samples::Samples;
use super::{Field, FieldError, Sampling};
use potamoi_base::camera::Camera;
use potamoi_base::mask::Mask;

/// The rays of a frame up to where each stops in floating point.
pub struct RayLengths<'a> {
    field: &'a dyn Field,
    camera: &'a Camera,
    sampling: Sampling,
    /// One element a pixel, row after row.
    rays: Vec<Stop>,
}

/// The length of one ray.
#[derive(Default)]
struct Stop {
    /// Samples up to where it stops.
    samples: u32,
    /// Gathered samples among them.
    gathered: u32,
    /// Runs of gathered samples: the first of each, and one past the last.
    runs: Box<[[u32; 2]]>,
}

impl Stop {
    /// The lengths of the rays of some pixels.
    fn find(
        tile: &mut RayTile<'_>,
        sampling: &Sampling,
        camera: &Camera,
        pixels: &[[u32; 2]],
    ) -> Vec<Self> {
        let rays = pixels
            .iter()
            .map(|pixel| Samples::of(sampling, camera, *pixel));
        let rays: Vec<Samples> = rays.collect();
        let mut runs: Vec<Vec<[u32; 2]>> = vec![vec![]; rays.len()];
        let gathers = |slot: usize, k: u64| {
            // A ray has at most a million.
            let k = k as u32;
            match runs[slot].last_mut() {
                Some([_, end]) if *end == k => *end += 1,
                _ => runs[slot].push([k, k + 1]),
            }
        };
        let followed = tile.follow(sampling, &rays, gathers, None);
        let stops = followed.into_iter().zip(runs);
        stops
            .map(|(pixel, runs)| Self {
                samples: pixel.samples as u32,
                gathered: pixel.gathered as u32,
                runs: runs.into(),
            })
            .collect()
    }
}

impl<'a> RayLengths<'a> {
    /// Marches every ray of a camera through a field.
    ///
    /// # Errors
    /// Those of [`super::render_float`].
    pub fn find(field: &'a dyn Field, camera: &'a Camera) -> Result<Self, FieldError> {
        Self::masked(field, camera, None)
    }

    /// As [`RayLengths::find`], but only for the pixels of a mask; no samples are gathered for the
    /// others.
    ///
    /// # Errors
    /// Those of [`RayLengths::find`], or the mask does not have the camera's size.
    pub fn masked(
        field: &'a dyn Field,
        camera: &'a Camera,
        only: Option<&Mask>,
    ) -> Result<Self, FieldError> {
        let sampling = field.sampling();
        check(camera, &sampling)?;
        check_mask(camera, only)?;
        let followed = tiles([camera.width, camera.height])
            .into_par_iter()
            .map_init(
                || RayTile::new(field),
                |tile, mut pixels| {
                    if let Some(mask) = only {
                        pixels.retain(|[x, y]| mask.has((y * camera.width + x) as usize));
                    }
                    let stops = Stop::find(tile, &sampling, camera, &pixels);
                    (pixels, stops)
                },
            );
        let followed: Vec<_> = followed.collect();
        let mut rays = vec![];
        rays.resize_with((camera.width * camera.height) as usize, Stop::default);
        for ([x, y], stop) in followed
            .into_iter()
            .flat_map(|(at, stops)| at.into_iter().zip(stops))
        {
            rays[(y * camera.width + x) as usize] = stop;
        }
        Ok(Self {
            field,
            camera,
            sampling,
            rays,
        })
    }

    /// The field.
    #[must_use]
    pub fn field(&self) -> &'a dyn Field {
        self.field
    }

    /// The camera.
    #[must_use]
    pub fn camera(&self) -> &'a Camera {
        self.camera
    }

    /// Gathered samples of a pixel.
    #[must_use]
    pub fn gathered(&self, pixel: [u32; 2]) -> u32 {
        self.stop(pixel).gathered
    }

    /// Samples of a pixel up to where its ray stops, whether gathered or not.
    #[must_use]
    pub fn passed(&self, pixel: [u32; 2]) -> u64 {
        self.stop(pixel).samples.into()
    }

    fn stop(&self, [x, y]: [u32; 2]) -> &Stop {
        &self.rays[(y * self.camera.width + x) as usize]
    }

    /// The ray of a pixel, and its samples up to where it stops.
    pub(super) fn ray(&self, pixel: [u32; 2]) -> (Samples, u64) {
        let ray = Samples::of(&self.sampling, self.camera, pixel);
        (ray, self.stop(pixel).samples.into())
    }

    pub(super) const fn sampling(&self) -> &Sampling {
        &self.sampling
    }

    /// Calls `seen` with the position in the tables of every gathered sample of a pixel, front to
    /// back. `places` has one element a table. Each sample is divided into `parts`, spread evenly
    /// over its step; parts where the field is known to be empty are left out.
    pub fn samples(
        &self,
        pixel: [u32; 2],
        parts: u32,
        places: &mut [DVec3],
        mut seen: impl FnMut(&[DVec3]),
    ) {
        let stop = self.stop(pixel);
        if stop.gathered == 0 {
            return;
        }
        let ray = Samples::of(&self.sampling, self.camera, pixel);
        for k in stop.runs.iter().flat_map(|[from, to]| *from..*to) {
            let k = k.into();
            self.field.place(ray.at(k), places);
            seen(places);
            for part in 1..parts {
                let at = ray.between(k, f64::from(part) / f64::from(parts));
                if self.field.index(at, places) {
                    seen(places);
                }
            }
        }
    }
}
