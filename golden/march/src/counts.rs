//! What the units did for a frame.

use std::collections::BTreeMap;

use potamoi_formats::units::OpCode;

use crate::streams::{Streams, UnitStreams, Visit};
use crate::work::Work;

/// Counts of a frame.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FixedStats {
    /// Ray groups.
    pub groups: u64,
    /// Rays, those that miss the volume included.
    pub rays: u64,
    /// Samples inside the volume, gathered or not.
    pub samples: u64,
    /// MVoxels loaded, over all ray groups.
    pub tasks: u64,
    /// Entries of the ray index table: samples gathered, those that lie in
    /// several MVoxels once in each.
    pub entries: u64,
    /// Of them, entries that lack vertices.
    pub split_entries: u64,
    /// The most samples that waited for others while the next MVoxels were
    /// gathered; none where faces are shared.
    pub waiting: u64,
    /// Bytes, stream by stream.
    pub streams: Streams,
    /// Of the bytes of MVoxels, those that were fetched row by row, from
    /// anywhere in a table that does not stream.
    pub scattered_bytes: u64,
    /// Samples of each table of a field of several, by the order in which they
    /// were gathered.
    pub orders: Vec<Orders>,
    /// Feature codes out of the gathering unit.
    pub features: u64,
    /// Elements out of the vector unit, by operation.
    pub vector_elements: BTreeMap<OpCode, u64>,
    /// Products of the MAC array.
    pub products: u64,
    /// Sums of the MAC array that were held at an end of their format.
    pub held: u64,
    /// Sines and cosines of features.
    pub waves: u64,
    /// Samples that added to a pixel.
    pub composited: u64,
    /// Rays that stopped early.
    pub stopped: u64,
}

/// Samples of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Orders {
    /// Gathered MVoxel by MVoxel.
    pub streamed: u64,
    /// Gathered in the order of the samples.
    pub row_by_row: u64,
}

impl FixedStats {
    /// Counts MVoxels and what each moves.
    pub fn count<'v>(&mut self, visits: impl IntoIterator<Item = &'v Visit>, reads: UnitStreams) {
        for visit in visits {
            self.tasks += 1;
            self.entries += visit.whole + visit.split;
            self.split_entries += visit.split;
            self.features += visit.whole * visit.channels as u64;
            self.streams.visit(visit, reads);
        }
    }

    /// The first table, from 1, from which on most samples of each were gathered
    /// row by row; none where the last was not.
    #[must_use]
    pub fn reverts_from(&self) -> Option<usize> {
        let streams = |o: &Orders| o.row_by_row <= o.streamed;
        let kept = self
            .orders
            .iter()
            .rposition(streams)
            .map_or(0, |last| last + 1);
        (kept < self.orders.len()).then_some(kept + 1)
    }

    /// Takes over what compositing counted.
    pub fn take(&mut self, work: Work) {
        self.vector_elements = work.elements;
        (self.products, self.held, self.waves) = (work.products, work.held, work.waves);
        (self.composited, self.stopped) = (work.composited, work.stopped);
    }
}
