//! Visible samples whose colours are computed in batches.

use glam::DVec3;

use super::Field;
use super::pixel::Pixel;
use super::samples::Samples;

/// Samples in a batch, or more.
const BATCH: usize = 64;

/// Visible samples of a tile of rays, each ray's front to back.
pub(super) struct ColourQueue<'f> {
    field: &'f dyn Field,
    /// Whether colours depend on the viewing direction; if not, they are those along the zero
    /// vector.
    directions: bool,
    /// Encoded direction of each ray.
    encoded: Vec<f64>,
    /// Ray and weight of each sample, and what its colour is computed from.
    samples: Vec<(usize, f64)>,
    kept: Vec<f64>,
    towards: Vec<f64>,
    colours: Vec<DVec3>,
}

impl<'f> ColourQueue<'f> {
    pub(super) fn new(field: &'f dyn Field, directions: bool) -> Self {
        Self {
            field,
            directions,
            encoded: vec![],
            samples: vec![],
            kept: vec![],
            towards: vec![],
            colours: vec![],
        }
    }

    /// Starts with the rays of another tile.
    pub(super) fn start(&mut self, rays: &[Samples]) {
        self.encoded.clear();
        for ray in rays {
            let towards = match self.directions {
                true => ray.direction,
                false => DVec3::ZERO,
            };
            self.field.encode(towards, &mut self.encoded);
        }
    }

    /// Adds a visible sample.
    pub(super) fn push(&mut self, slot: usize, weight: f64, kept: &[f64]) {
        self.samples.push((slot, weight));
        self.kept.extend_from_slice(kept);
    }

    /// As [`ColourQueue::add`], but only if the samples fill a batch.
    pub(super) fn add_full(&mut self, pixels: &mut [Pixel]) {
        if self.samples.len() >= BATCH {
            self.add(pixels);
        }
    }

    /// Adds the colours of all samples to their pixels.
    pub(super) fn add(&mut self, pixels: &mut [Pixel]) {
        let width = self.field.encoded();
        self.towards.clear();
        for (slot, _) in &self.samples {
            let own = &self.encoded[slot * width..][..width];
            self.towards.extend_from_slice(own);
        }
        self.field
            .colours(&self.kept, &self.towards, &mut self.colours);
        for ((slot, weight), colour) in self.samples.iter().zip(&self.colours) {
            pixels[*slot].colour += *weight * *colour;
        }
        self.samples.clear();
        self.kept.clear();
    }
}
