//! Entries in the visiting order of their MVoxels ([`Load`]), and the sums of samples that several
//! MVoxels share.

use std::collections::HashMap;

use super::part::{Load, Part, Shape};
use potamoi_march::streams::Visit;
use potamoi_reference::GatherTask;

/// Gathering tasks of one table.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Gathers {
    /// Tasks in order of execution.
    pub tasks: Vec<GatherTask>,
    /// For each entry of each task, its sample.
    pub samples: Vec<u32>,
    /// Traffic of each MVoxel.
    pub(crate) visits: Vec<Visit>,
    /// Samples with entries in several MVoxels.
    pub(crate) parted: Parted,
    /// Whether rows are fetched as samples need them.
    pub row_by_row: bool,
}

/// Samples whose vertices lie in several MVoxels.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Parted {
    /// Their numbers, in the order in which they were begun.
    pub(crate) samples: Vec<u32>,
    /// For each of them, channel after channel, the sums that the tasks do not gather.
    pub(crate) sums: Vec<i64>,
    /// Peak number of incomplete ones.
    pub(crate) waiting: u64,
}

/// A part of a sample, its MVoxel, and the distance of that from the camera's.
pub(super) struct Placed {
    pub(super) distance: u64,
    pub(super) mvoxel: usize,
    pub(super) sample: u32,
    pub(super) part: Part,
}

impl Gathers {
    /// Gathers of tasks with complete entries, in the order of the samples.
    pub(super) fn row_by_row(tasks: Vec<GatherTask>, samples: usize) -> Self {
        Self {
            visits: tasks.iter().map(Visit::of).collect(),
            tasks,
            samples: (0..samples as u32).collect(),
            parted: Parted::default(),
            row_by_row: true,
        }
    }

    /// Number of MVoxels, or of tasks if rows are fetched as samples need them.
    #[must_use]
    pub fn mvoxels(&self) -> usize {
        self.visits.len()
    }

    /// Number of rows loaded.
    #[must_use]
    pub fn rows(&self) -> u64 {
        self.visits.iter().map(|visit| visit.rows).sum()
    }

    /// Adds the unit's unrounded results to the `sums` of samples in several MVoxels; passes on
    /// those of the others.
    pub(super) fn add_up(
        &self,
        exact: &[i32],
        sums: &mut [i64],
        mut other: impl FnMut(u32, &[i32]),
    ) {
        let width = sums.len() / self.parted.samples.len().max(1);
        let numbers = self
            .parted
            .samples
            .iter()
            .zip(sums.chunks_exact_mut(width.max(1)));
        let mut of_sample: HashMap<u32, &mut [i64]> = numbers.map(|(s, sums)| (*s, sums)).collect();
        for (sample, own) in self.samples.iter().zip(exact.chunks_exact(width.max(1))) {
            match of_sample.get_mut(sample) {
                Some(sums) => sums
                    .iter_mut()
                    .zip(own)
                    .for_each(|(sum, part)| *sum += i64::from(*part)),
                None => other(*sample, own),
            }
        }
    }

    /// Orders entries by their MVoxels, whose rows are `rows`: the nearest first, and within each
    /// by sample. An MVoxel is loaded up to the last row used.
    pub(super) fn visiting<'r>(
        mut placed: Vec<Placed>,
        shape: Shape,
        rows: impl Fn(usize) -> &'r [i16],
    ) -> Self {
        placed.sort_unstable_by_key(|e| (e.distance, e.mvoxel, e.sample));
        let mut made = Self::default();
        let mut sums = Sums::new(shape, &placed);
        for same in placed.chunk_by(|a, b| a.mvoxel == b.mvoxel) {
            let own = rows(same[0].mvoxel);
            let mut load = Load::default();
            for Placed { sample, part, .. } in same {
                if load.add(part, &shape) {
                    made.samples.push(*sample);
                }
                if part.held != shape.whole() {
                    sums.add(*sample, part, own);
                }
            }
            sums.rest();
            if let Some((visit, task)) = load.done(own, &shape) {
                made.visits.push(visit);
                made.tasks.extend(task);
            }
        }
        made.parted = sums.parted;
        made
    }
}

/// State of the sums while MVoxels are visited.
struct Sums {
    shape: Shape,
    parted: Parted,
    /// For each sample of the batch, its number among those in several MVoxels.
    number: Vec<Option<u32>>,
    /// For each of those, the corners received.
    came: Vec<u8>,
    /// Number of incomplete ones.
    open: u64,
}

impl Sums {
    fn new(shape: Shape, placed: &[Placed]) -> Self {
        let parted = placed.iter().filter(|e| e.part.held != shape.whole());
        let samples = parted.map(|e| e.sample as usize + 1).max();
        Self {
            shape,
            parted: Parted::default(),
            number: vec![None; samples.unwrap_or_default()],
            came: vec![],
            open: 0,
        }
    }

    fn add(&mut self, sample: u32, part: &Part, rows: &[i16]) {
        let channels = self.shape.channels;
        let number = &mut self.number[sample as usize];
        let number = *number.get_or_insert_with(|| {
            self.parted.samples.push(sample);
            self.parted
                .sums
                .resize(self.came.len() * channels + channels, 0);
            self.came.push(0);
            self.open += 1;
            self.came.len() as u32 - 1
        }) as usize;
        self.came[number] |= part.held;
        if self.came[number] == self.shape.whole() {
            self.open -= 1;
        }
        if self.shape.exact_sums {
            return;
        }
        let sums = &mut self.parted.sums[number * channels..][..channels];
        part.add_to(sums, rows, &self.shape);
    }

    /// Updates the peak after an MVoxel was visited.
    fn rest(&mut self) {
        self.parted.waiting = self.parted.waiting.max(self.open);
    }
}
