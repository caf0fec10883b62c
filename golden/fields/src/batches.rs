//! The schedule of a field in several tables: ray groups, and the batches in which the samples of
//! a group are gathered.
//!
//! A batch takes the same number of samples from every ray that has not stopped, front to back;
//! rays stop only between batches. So a batch of many samples a ray gathers many samples behind
//! the points where rays stop, and one of few samples loads the MVoxels of the group more often.
//! The renderer and the traffic count (`characterise`) use the same batches.

use glam::DVec3;
use rayon::prelude::*;

use super::samples::Samples;
use super::{Field, Sampling};
use crate::gather_plan::CodedTable;
use potamoi_base::camera::Camera;
use potamoi_march::Span;

/// Limits of a batch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BatchSize {
    /// Maximum number of samples a ray, at least 1.
    pub samples: u32,
    /// Maximum number of entries over all tables; every ray may have one sample in any case.
    pub entries: usize,
}

impl BatchSize {
    /// Maximum number of entries in memory: about 200 MB here.
    pub const ENTRIES: usize = 1 << 21;

    /// The batch size of a field in one volume, whose batches end with an MVoxel.
    pub const VOLUME: Self = Self {
        samples: u32::MAX,
        entries: 1 << 18,
    };

    /// The batch size for some tables. The number of samples is the square root of a third of the
    /// ratio between the bytes of an MVoxel in each table and the bytes of a sample.
    ///
    /// With `d` samples a ray, MVoxels are loaded about `n / d` times, and `d / 2` samples a ray
    /// are gathered behind its stop; the sum is least at a root. The third is chosen by counting
    /// (docs/explanation/fields.md), and holds for ray groups of all sizes: a batch grows with the
    /// number of rays in a group.
    #[must_use]
    pub fn of(tables: &[CodedTable]) -> Self {
        let sum = |of: fn(&CodedTable) -> u64| tables.iter().map(of).sum::<u64>();
        let [mvoxels, sample] = [CodedTable::mvoxel_bytes, CodedTable::sample_bytes].map(sum);
        let samples = (mvoxels / (3 * sample.max(1))).isqrt();
        Self {
            samples: samples.clamp(1, 64) as u32,
            entries: Self::ENTRIES,
        }
    }
}

/// A ray of a group, and its next sample.
struct Ray {
    samples: Samples,
    next: u64,
}

/// The rays of a group, and their next samples.
pub struct SampleBatches<'f> {
    field: &'f dyn Field,
    void_test: bool,
    rays: Vec<Ray>,
}

/// Samples of a batch, ray after ray.
#[derive(Default)]
pub struct SampleBatch {
    pub at: Vec<DVec3>,
    pub(crate) slots: Vec<u32>,
    pub spans: Vec<Span>,
}

impl<'f> SampleBatches<'f> {
    /// Rays through pixels, at their first sample. Without `void_test`, no sample is skipped.
    pub fn new(
        field: &'f dyn Field,
        void_test: bool,
        sampling: &Sampling,
        camera: &Camera,
        pixels: &[[u32; 2]],
    ) -> Self {
        let rays = pixels.iter().map(|pixel| Ray {
            samples: Samples::of(sampling, camera, *pixel),
            next: 0,
        });
        Self {
            field,
            void_test,
            rays: rays.collect(),
        }
    }

    /// Unit directions of the rays.
    pub(crate) fn directions(&self) -> impl ExactSizeIterator<Item = DVec3> {
        self.rays.iter().map(|ray| ray.samples.direction)
    }

    /// Samples along all rays, whether gathered or not.
    pub(crate) fn samples(&self) -> u64 {
        self.rays.iter().map(|ray| ray.samples.count).sum()
    }

    /// The next samples of every ray that is `alive`, except those where the field is known to be
    /// empty; empty at the end.
    pub fn next(&mut self, alive: impl Fn(u32) -> bool + Sync, size: BatchSize) -> SampleBatch {
        let on = |(slot, ray): (u32, &Ray)| ray.next < ray.samples.count && alive(slot);
        let tables = self.field.tables().len();
        let count = (0..).zip(&self.rays).filter(|ray| on((ray.0, ray.1)));
        let bound = size.entries / tables.max(1) / count.count().max(1);
        let most = bound.min(size.samples as usize).max(1);
        let (field, void_test) = (self.field, self.void_test);
        let take = |(slot, ray): (usize, &mut Ray)| {
            let mut own = vec![];
            if !on((slot as u32, ray)) {
                return own;
            }
            while own.len() < most && ray.next < ray.samples.count {
                let next = match void_test {
                    true => ray.samples.next_held(field, ray.next),
                    false => Some(ray.next),
                };
                ray.next = next.map_or(ray.samples.count, |next| next + 1);
                own.extend(next.map(|next| ray.samples.at(next)));
            }
            own
        };
        let rays = self.rays.par_iter_mut().enumerate();
        let taken: Vec<Vec<DVec3>> = rays.map(take).collect();
        let mut batch = SampleBatch::default();
        for (slot, own) in (0..).zip(taken).filter(|(_, own)| !own.is_empty()) {
            batch.spans.push(Span {
                ray: slot,
                start: batch.at.len() as u32,
                len: own.len() as u32,
            });
            batch.slots.extend(own.iter().map(|_| slot));
            batch.at.extend(own);
        }
        batch
    }
}
