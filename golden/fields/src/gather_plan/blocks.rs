//! A table hashed by MVoxel: each entry of the hash is a block of vertices, which is an MVoxel, so
//! that the table streams (paper, Sec. "Memory Optimizations", hierarchical encodings).
//!
//! Blocks that share an entry lie apart and have different neighbours, so no entry can hold its
//! neighbours' faces: the halo is always split.
//!
//! If MVoxels are *under-used* the table reverts to the order of samples. This is the case where
//! the MVoxels of a batch, each loaded once and up to the last row used, have more rows than its
//! samples fetch row by row.

use std::sync::Arc;

use glam::DVec3;

use super::mvoxels::placed;
use super::part::Shape;
use super::visit::Gathers;
use super::{Located, ScatteredTable, Tally};
use crate::{FieldError, HashUnit};
use potamoi_march::tiling::{Halo, Tiling, cell};

/// A quantised table hashed by MVoxel.
#[derive(Debug, Clone, PartialEq)]
pub struct BlockTable {
    points: [usize; 3],
    /// Tiling in whole blocks.
    tiling: Tiling,
    shape: Shape,
    codes: Arc<[i16]>,
    /// The order of samples; the only order if an MVoxel has fewer rows than a block.
    scattered: ScatteredTable,
    streams: bool,
}

impl BlockTable {
    pub(super) fn new(
        points: [usize; 3],
        shape: Shape,
        codes: Vec<i16>,
        rows: usize,
    ) -> Result<Self, FieldError> {
        let edge = HashUnit::BLOCK;
        let codes: Arc<[i16]> = codes.into();
        Ok(Self {
            points,
            tiling: Tiling::new(
                points.map(|p| p.next_multiple_of(edge)),
                [edge; 3],
                Halo::Split,
            ),
            shape,
            scattered: ScatteredTable::new(points, HashUnit::MVoxel, shape, &codes, rows)?,
            codes,
            streams: rows >= HashUnit::BLOCK_ROWS,
        })
    }

    /// Whether an MVoxel can hold a block.
    pub(super) const fn streams(&self) -> bool {
        self.streams
    }

    /// The table in the order of samples.
    pub(super) const fn scattered(&self) -> &ScatteredTable {
        &self.scattered
    }

    /// Counts what a sample reads MVoxel by MVoxel.
    pub(super) fn touch(&self, place: DVec3, tally: &mut Tally) {
        let (low, fraction) = cell(self.points, place.to_array());
        tally.touch(&self.tiling, &self.tiling.place(low, fraction));
    }

    pub(super) fn gathers(&self, eye: DVec3, samples: &[Located], weight_bits: u32) -> Gathers {
        if !self.streams {
            return self.scattered.gathers(samples, weight_bits);
        }
        let [streamed, reverted] = self.orders(eye, samples, weight_bits);
        if streamed.rows() > reverted.rows() {
            reverted
        } else {
            streamed
        }
    }

    /// The gathers in both orders: MVoxel by MVoxel, and in the order of the samples.
    #[must_use]
    pub fn orders(&self, eye: DVec3, samples: &[Located], weight_bits: u32) -> [Gathers; 2] {
        [
            self.streamed(eye, samples),
            self.scattered.gathers(samples, weight_bits),
        ]
    }

    /// The gathers MVoxel by MVoxel, however few of their rows are used.
    fn streamed(&self, eye: DVec3, samples: &[Located]) -> Gathers {
        let placed = placed(&self.tiling, self.points, self.shape, eye, samples);
        let rows = self.codes.len() / self.shape.channels;
        let wide = HashUnit::BLOCK_ROWS * self.shape.channels;
        Gathers::visiting(placed, self.shape, |mvoxel| {
            let first = self.tiling.first(mvoxel);
            let row = HashUnit::MVoxel.row(first, rows);
            &self.codes[row * self.shape.channels..][..wide]
        })
    }
}
