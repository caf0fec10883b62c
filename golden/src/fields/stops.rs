//! Where the rays of a frame stop, found once; the samples before that are found
//! again from it without gathering anything.

use glam::DVec3;
use rayon::prelude::*;

use super::march::{Samples, Worker, advance, check};
use super::{Field, FieldError, Sampling};
use crate::camera::Camera;

/// The rays of a frame up to where each stops in floating point.
pub struct Stops<'a> {
    field: &'a dyn Field,
    camera: &'a Camera,
    sampling: Sampling,
    /// Of each pixel, row after row: samples up to where its ray stops, and those
    /// of them that are gathered.
    rays: Vec<[u32; 2]>,
}

impl<'a> Stops<'a> {
    /// Marches every ray of a camera through a field.
    ///
    /// # Errors
    /// As [`super::render_float`].
    pub fn find(field: &'a dyn Field, camera: &'a Camera) -> Result<Self, FieldError> {
        let sampling = field.sampling();
        check(camera, &sampling)?;
        let rays = (0..camera.width * camera.height)
            .into_par_iter()
            .map_init(
                || Worker::new(field),
                |worker, i| {
                    let pixel = [i % camera.width, i / camera.width];
                    let ray = Samples::of(&sampling, camera, pixel);
                    let marched = advance(field, &sampling, &ray, worker);
                    // A ray has at most a million.
                    [marched.samples as u32, marched.gathered as u32]
                },
            )
            .collect();
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

    /// Samples of a pixel that are gathered.
    #[must_use]
    pub fn gathered(&self, [x, y]: [u32; 2]) -> u32 {
        self.rays[(y * self.camera.width + x) as usize][1]
    }

    /// The ray of a pixel, and its samples up to where it stops.
    pub(super) fn ray(&self, [x, y]: [u32; 2]) -> (Samples, u64) {
        let [samples, _] = self.rays[(y * self.camera.width + x) as usize];
        let ray = Samples::of(&self.sampling, self.camera, [x, y]);
        (ray, samples.into())
    }

    pub(super) const fn sampling(&self) -> &Sampling {
        &self.sampling
    }

    /// Tells of every sample of a pixel that is gathered where it lies in the
    /// tables, front to back. `places` has one a table. Steps are cut into so many
    /// `parts`, of which each has a sample.
    pub fn samples(
        &self,
        pixel: [u32; 2],
        parts: u32,
        places: &mut [DVec3],
        mut seen: impl FnMut(&[DVec3]),
    ) {
        let (ray, samples) = self.ray(pixel);
        for k in 0..samples {
            for part in 0..parts {
                let at = ray.between(k, f64::from(part) / f64::from(parts));
                if self.field.index(at, places) {
                    seen(places);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]
    use super::*;
    use crate::fields::render_float;
    use crate::scene::{Model, Scene};

    /// As many samples as the renderer counts, each where a gathered one lies.
    #[test]
    fn rays_stop_where_the_renderer_stops_them() {
        let mut scene = Scene::open("moons:efficientnerf").unwrap();
        scene.set_size(Some(40), Some(30)).unwrap();
        let Model::Field(field) = scene.model() else {
            panic!("a field")
        };
        let frame = render_float(&**field, scene.camera(), [0.0; 3]).unwrap();
        let stops = Stops::find(&**field, scene.camera()).unwrap();
        let (mut told, mut kept, mut samples) = (0, 0, 0);
        let mut places = vec![DVec3::ZERO; field.tables().len()];
        for pixel in (0..30).flat_map(|y| (0..40).map(move |x| [x, y])) {
            let before = told;
            stops.samples(pixel, 1, &mut places, |places| {
                let mut rows = 0;
                field.tables()[0].corners(places[0], |_, _| rows += 1);
                assert_eq!(rows, 1);
                told += 1;
            });
            assert_eq!(told - before, u64::from(stops.gathered(pixel)));
            kept += u64::from(stops.gathered(pixel));
            samples += stops.ray(pixel).1;
        }
        assert_eq!([told, kept], [frame.gathered; 2]);
        assert_eq!(samples, frame.samples);
        assert!(told > 1000, "{told}");
        let mut finer = 0;
        stops.samples([20, 15], 3, &mut places, |_| finer += 1);
        let own = stops.gathered([20, 15]);
        assert!(own > 2 && (2 * own..=4 * own).contains(&finer), "{finer}");
    }
}
