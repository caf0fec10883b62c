//! One ray in the paper's three stages, one after another; [`render_float`](super::render_float)
//! interleaves them sample by sample.

use glam::DVec3;

use super::RayLengths;
use super::samples::Samples;

/// A ray, and the results of its stages.
pub struct RayStages<'a> {
    stops: &'a RayLengths<'a>,
    ray: Option<Samples>,
    /// Samples up to where the ray stops.
    samples: u64,
    /// Positions of each gathered sample in every table, and then its features.
    places: Vec<DVec3>,
    features: Vec<f64>,
    scratch: Vec<f64>,
}

impl<'a> RayStages<'a> {
    /// Stages for rays of known lengths.
    #[must_use]
    pub fn new(stops: &'a RayLengths<'a>) -> Self {
        Self {
            stops,
            ray: None,
            samples: 0,
            places: vec![],
            features: vec![],
            scratch: vec![],
        }
    }

    /// Starts the ray of a pixel.
    pub fn aim(&mut self, pixel: [u32; 2]) {
        let (ray, samples) = self.stops.ray(pixel);
        (self.ray, self.samples) = (Some(ray), samples);
    }

    /// Indexing: computes the positions of the samples.
    pub fn index(&mut self) {
        self.places.clear();
        let Some(ray) = self.ray else { return };
        let field = self.stops.field();
        let tables = field.tables().len();
        for k in 0..self.samples {
            let from = self.places.len();
            self.places.resize(from + tables, DVec3::ZERO);
            if !field.index(ray.at(k), &mut self.places[from..]) {
                self.places.truncate(from);
            }
        }
    }

    /// Gathering: computes the features.
    pub fn gather(&mut self) {
        let tables = self.stops.field().tables();
        let channels = self.stops.field().channels();
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

    /// Feature computation: returns the colour of the ray.
    pub fn compute(&mut self) -> DVec3 {
        let Some(ray) = self.ray else {
            return DVec3::ZERO;
        };
        let (field, sampling) = (self.stops.field(), self.stops.sampling());
        let (mut left, mut colour) = (1.0, DVec3::ZERO);
        for row in self.features.chunks_exact(field.channels().max(1)) {
            let alpha = -(-field.depth(row)).exp_m1();
            let weight = alpha * left;
            if alpha > sampling.least_opacity {
                left *= 1.0 - alpha;
                if weight > sampling.least_weight {
                    colour += weight * field.colour(row, ray.direction, &mut self.scratch);
                }
            }
        }
        colour
    }
}
