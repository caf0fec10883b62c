//! Counts of the units' work for a frame.

use std::collections::BTreeMap;

use potamoi_formats::units::OpCode;

use crate::sample_outcomes::SampleOutcomes;
use crate::streams::{Streams, UnitStreams, Visit};
use crate::work::Work;

/// Work and traffic of a frame.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FixedStats {
    /// Ray groups.
    pub groups: u64,
    /// Rays, including those that miss the volume.
    pub rays: u64,
    /// Samples inside the volume, whether gathered or not.
    pub samples: u64,
    /// MVoxels loaded, over all ray groups.
    pub tasks: u64,
    /// Entries of the ray index table: gathered samples, with one entry in each MVoxel that a
    /// sample needs.
    pub entries: u64,
    /// Entries that lack vertices, a subset of `entries`.
    pub split_entries: u64,
    /// Largest number of samples that waited for further MVoxels at one time; 0 with a shared
    /// halo.
    pub waiting: u64,
    /// Bytes by stream.
    pub streams: Streams,
    /// Bytes of MVoxels fetched row by row, from anywhere in a table that does not stream; a part
    /// of the MVoxel bytes.
    pub scattered_bytes: u64,
    /// For a field of several tables: samples of each table by gathering order.
    pub orders: Vec<Orders>,
    /// Feature codes that the gathering unit returned.
    pub features: u64,
    /// Elements that the vector unit returned, by operation.
    pub vector_elements: BTreeMap<OpCode, u64>,
    /// Operations of the MAC array.
    pub products: u64,
    /// Sums of the MAC array that saturated.
    pub held: u64,
    /// Sines and cosines of encoded features.
    pub waves: u64,
    /// Samples by what they change.
    pub outcomes: SampleOutcomes,
    /// Rays that terminated early.
    pub stopped: u64,
}

/// Samples of one table by gathering order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Orders {
    /// Gathered MVoxel by MVoxel.
    pub streamed: u64,
    /// Gathered in the order of the samples.
    pub row_by_row: u64,
}

impl FixedStats {
    /// Counts the given MVoxels and their traffic.
    pub fn count<'v>(&mut self, visits: impl IntoIterator<Item = &'v Visit>, reads: UnitStreams) {
        for visit in visits {
            self.tasks += 1;
            self.entries += visit.whole + visit.split;
            self.split_entries += visit.split;
            self.features += visit.whole * visit.channels as u64;
            self.streams.visit(visit, reads);
        }
    }

    /// The first table, counted from 1, from which on most samples of every table were gathered
    /// row by row; `None` if the last table was not.
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

    /// Takes over the counts of compositing.
    pub fn take(&mut self, work: Work) {
        self.vector_elements = work.elements;
        (self.products, self.held, self.waves) = (work.products, work.held, work.waves);
        (self.outcomes, self.stopped) = (work.outcomes, work.stopped);
    }
}
