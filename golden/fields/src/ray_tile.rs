//! Rays that are followed side by side, so that their samples are computed in batches.
//!
//! In every round each ray that has not stopped takes its next sample where the field may be
//! non-empty. So no sample behind the stop of a ray is computed, and each ray composites its
//! samples one after another, as if it were alone.

use glam::DVec3;

use super::colour_queue::ColourQueue;
use super::pixel::Pixel;
use super::samples::Samples;
use super::table::gather_all;
use super::{Field, Sampling};

/// Pixels along an edge of a tile of rays.
const EDGE: u32 = 8;

/// The pixels of each tile of a picture, row after row.
pub(super) fn tiles([width, height]: [u32; 2]) -> Vec<Vec<[u32; 2]>> {
    let corners = (0..height).step_by(EDGE as usize).flat_map(|top| {
        let lefts = (0..width).step_by(EDGE as usize);
        lefts.map(move |left| [left, top])
    });
    let pixels = corners.map(|[left, top]| {
        let lines = top..(top + EDGE).min(height);
        lines
            .flat_map(|y| (left..(left + EDGE).min(width)).map(move |x| [x, y]))
            .collect()
    });
    pixels.collect()
}

/// Buffers for the rays of a tile, reused from tile to tile.
pub(super) struct RayTile<'f> {
    field: &'f dyn Field,
    /// The next sample of each ray.
    next: Vec<u64>,
    /// The rays that go on.
    live: Vec<usize>,
    /// The ray and the number of each sample of a round.
    held: Vec<(usize, u64)>,
    /// Positions of each sample in every table, and then its features.
    places: Vec<DVec3>,
    features: Vec<f64>,
    depths: Vec<f64>,
    kept: Vec<f64>,
}

impl<'f> RayTile<'f> {
    pub(super) fn new(field: &'f dyn Field) -> Self {
        Self {
            field,
            next: vec![],
            live: vec![],
            held: vec![],
            places: vec![],
            features: vec![],
            depths: vec![],
            kept: vec![],
        }
    }

    /// Follows rays to where each stops: its samples, its gathered samples and its final
    /// transmittance. `gathers` is called with the ray and the number of each gathered sample, a
    /// ray's front to back; `colours`, if any, adds the colours of visible samples.
    pub(super) fn follow(
        &mut self,
        sampling: &Sampling,
        rays: &[Samples],
        mut gathers: impl FnMut(usize, u64),
        mut colours: Option<&mut ColourQueue<'f>>,
    ) -> Vec<Pixel> {
        let mut pixels = vec![Pixel::CLEAR; rays.len()];
        if let Some(queue) = &mut colours {
            queue.start(rays);
        }
        self.next.clear();
        self.next.resize(rays.len(), 0);
        self.live.clear();
        self.live.extend(0..rays.len());
        loop {
            self.take(rays, &mut pixels);
            if self.held.is_empty() {
                break;
            }
            self.compute();
            let width = self.field.kept().max(1);
            let samples = self.held.iter().zip(&self.depths);
            for ((held, depth), kept) in samples.zip(self.kept.chunks_exact(width)) {
                let (slot, k) = *held;
                let pixel = &mut pixels[slot];
                gathers(slot, k);
                pixel.gathered += 1;
                let alpha = -(-depth).exp_m1();
                let weight = alpha * pixel.left;
                if alpha > sampling.least_opacity {
                    pixel.left *= 1.0 - alpha;
                    if weight > sampling.least_weight {
                        pixel.coloured += 1;
                        pixel.weight += weight;
                        pixel.moment += weight * rays[slot].distance(k);
                        if let Some(queue) = &mut colours {
                            queue.push(slot, weight, kept);
                        }
                    }
                }
                if pixel.left < sampling.stop {
                    pixel.samples = k + 1;
                    self.next[slot] = rays[slot].count;
                }
            }
            if let Some(queue) = &mut colours {
                queue.add_full(&mut pixels);
            }
        }
        if let Some(queue) = colours {
            queue.add(&mut pixels);
        }
        pixels
    }

    /// Takes the next sample of each ray.
    fn take(&mut self, rays: &[Samples], pixels: &mut [Pixel]) {
        let (field, tables) = (self.field, self.field.tables().len());
        let Self {
            next, held, places, ..
        } = self;
        held.clear();
        places.clear();
        self.live.retain(|slot| {
            let ray = &rays[*slot];
            let next = &mut next[*slot];
            if *next == ray.count {
                return false;
            }
            let Some(k) = ray.next_held(field, *next) else {
                // The pixel stops at the end of its ray.
                *next = ray.count;
                pixels[*slot].samples = ray.count;
                return false;
            };
            *next = k + 1;
            if *next == ray.count {
                pixels[*slot].samples = ray.count;
            }
            held.push((*slot, k));
            let from = places.len();
            places.resize(from + tables, DVec3::ZERO);
            field.place(ray.at(k), &mut places[from..]);
            true
        });
    }

    /// Gathers the samples of a round, and computes their depths.
    fn compute(&mut self) {
        let field = self.field;
        self.features.clear();
        self.features
            .resize(self.held.len() * field.channels(), 0.0);
        gather_all(field.tables(), &self.places, &mut self.features);
        field.depths(&self.features, &mut self.depths, &mut self.kept);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::voxels::{Grid, Layout, StoredField};
    use potamoi_base::camera::Camera;

    #[test]
    fn tiles_have_every_pixel_once() {
        for size in [[1, 1], [8, 8], [9, 17], [30, 5]] {
            let mut all: Vec<[u32; 2]> = tiles(size).concat();
            all.sort_by_key(|[x, y]| [*y, *x]);
            let expected = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| [x, y]));
            assert!(all.into_iter().eq(expected), "{size:?}");
        }
    }

    /// A ray in a tile has the samples, the transmittance and the colour of one that is alone, to
    /// the last bit, wherever the others stop.
    #[test]
    fn a_ray_is_the_same_alone() {
        let edge = 2.0 / 11.0;
        let grid = Grid::bake(
            [12; 3],
            DVec3::splat(-1.0),
            edge,
            Layout::Linear,
            |at, vertex| {
                for (i, value) in vertex.iter_mut().enumerate() {
                    *value = ((at.x * 3.0 + at.y * i as f64).sin() + at.z * 2.0 * at.x) as f32;
                }
            },
        );
        let field = StoredField::from(grid.unwrap());
        let eye = DVec3::new(0.3, -0.5, -3.0);
        let camera = Camera::look_at(eye, DVec3::ZERO, DVec3::Y, 0.6, 8, 8);
        let sampling = field.sampling();
        let pixels = (0..64u32).map(|i| [i % 8, i / 8]);
        let rays: Vec<Samples> = pixels
            .map(|pixel| Samples::of(&sampling, &camera, pixel))
            .collect();
        let follow = |rays: &[Samples]| {
            let mut queue = ColourQueue::new(&field, true);
            let mut gathered = vec![vec![]; rays.len()];
            let gathers = |slot: usize, k| gathered[slot].push(k);
            let made = RayTile::new(&field).follow(&sampling, rays, gathers, Some(&mut queue));
            let facts = made.into_iter().zip(gathered).map(|(pixel, gathered)| {
                let numbers = [pixel.left, pixel.distance(), pixel.colour.x, pixel.colour.z];
                let counts = [pixel.samples, pixel.gathered, pixel.coloured];
                (numbers.map(f64::to_bits), counts, gathered)
            });
            facts.collect::<Vec<_>>()
        };
        let together = follow(&rays);
        for (ray, together) in rays.iter().zip(&together) {
            assert_eq!(
                follow(std::slice::from_ref(ray)),
                std::slice::from_ref(together)
            );
        }
        let stops = together.iter().filter(|(_, [samples, ..], _)| *samples > 0);
        assert!(stops.count() > 20);
    }
}
