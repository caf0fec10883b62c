//! One ray in the paper's three stages, one after another: what
//! [`render_float`](super::render_float) does sample by sample.

use glam::DVec3;

use super::march::{Samples, Worker, check, march};
use super::{Field, FieldError, Sampling};
use crate::camera::Camera;

/// A ray, and what its stages leave for the next.
pub struct RayStages<'a> {
    field: &'a dyn Field,
    camera: &'a Camera,
    sampling: Sampling,
    worker: Worker,
    ray: Option<Samples>,
    /// Samples up to where the ray stops.
    samples: u64,
    /// Of each gathered sample, its place in every table, then its features.
    places: Vec<DVec3>,
    features: Vec<f64>,
}

impl<'a> RayStages<'a> {
    /// Rays of a camera through a field.
    ///
    /// # Errors
    /// As [`super::render_float`].
    pub fn new(field: &'a dyn Field, camera: &'a Camera) -> Result<Self, FieldError> {
        let sampling = field.sampling();
        check(camera, &sampling)?;
        Ok(Self {
            field,
            camera,
            sampling,
            worker: Worker::new(field),
            ray: None,
            samples: 0,
            places: vec![],
            features: vec![],
        })
    }

    /// Takes the ray of a pixel, and finds where it stops.
    pub fn aim(&mut self, pixel: [u32; 2]) {
        let worker = &mut self.worker;
        let marched = march(
            self.field,
            &self.sampling,
            self.camera,
            pixel,
            worker,
            |_, _| (),
        );
        self.samples = marched.samples;
        self.ray = Some(Samples::of(&self.sampling, self.camera, pixel));
    }

    /// Indexing: the places of its samples.
    pub fn index(&mut self) {
        self.places.clear();
        let Some(ray) = self.ray else { return };
        let tables = self.field.tables().len();
        for k in 0..self.samples {
            let from = self.places.len();
            self.places.resize(from + tables, DVec3::ZERO);
            if !self.field.index(ray.at(k), &mut self.places[from..]) {
                self.places.truncate(from);
            }
        }
    }

    /// Gathering: the features there.
    pub fn gather(&mut self) {
        let tables = self.field.tables();
        let channels = self.field.channels();
        let samples = self.places.len() / tables.len().max(1);
        self.features.clear();
        self.features.resize(samples * channels, 0.0);
        let rows = self.features.chunks_exact_mut(channels.max(1));
        for (places, mut row) in self.places.chunks_exact(tables.len().max(1)).zip(rows) {
            for (table, place) in tables.iter().zip(places) {
                let (own, rest) = row.split_at_mut(table.channels());
                table.gather(*place, own);
                row = rest;
            }
        }
    }

    /// Feature computation: the colour of the ray.
    pub fn compute(&mut self) -> DVec3 {
        let Some(ray) = self.ray else {
            return DVec3::ZERO;
        };
        let (mut left, mut colour) = (1.0, DVec3::ZERO);
        for row in self.features.chunks_exact(self.field.channels().max(1)) {
            let alpha = -(-self.field.depth(row)).exp_m1();
            let weight = alpha * left;
            if alpha > self.sampling.least_opacity {
                left *= 1.0 - alpha;
                if weight > self.sampling.least_weight {
                    let scratch = &mut self.worker.scratch;
                    colour += weight * self.field.colour(row, ray.direction, scratch);
                }
            }
        }
        colour
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]
    use super::*;
    use crate::fields::render_float;
    use crate::scene::{Model, Scene};

    /// The stages make the picture, to the order of its sums.
    #[test]
    fn stages_make_the_picture() {
        for name in ["cairn:ngp", "moons:efficientnerf"] {
            let mut scene = Scene::open(name).unwrap();
            scene.set_size(Some(24), None).unwrap();
            let Model::Field(field) = scene.model() else {
                panic!("a field")
            };
            let frame = render_float(&**field, scene.camera(), [0.0; 3]).unwrap();
            let mut rays = RayStages::new(&**field, scene.camera()).unwrap();
            let mut lit = 0;
            for (i, expected) in (0..).zip(&frame.picture.rgb) {
                rays.aim([i % 24, i / 24]);
                rays.index();
                rays.gather();
                let found = rays.compute();
                let off = found - DVec3::from(expected.map(f64::from));
                assert!(off.abs().max_element() < 1e-6, "{name} {i}: {found}");
                lit += u32::from(found != DVec3::ZERO);
            }
            assert!(lit > 50, "{lit}");
        }
    }
}
