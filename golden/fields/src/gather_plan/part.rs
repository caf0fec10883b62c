//! A visit of one MVoxel: the parts of samples that it holds, the task that the unit gathers, and
//! the traffic.
//!
//! A sample whose vertices lie in several MVoxels has an entry in each. Their unrounded sums are
//! added and rounded once, which equals the result of one entry of all its vertices. If the unit
//! returns unrounded sums (`gu.sums = "exact"`), all entries go through it, and an absent vertex
//! has weight 0. Otherwise only entries with all their vertices do, and the others are computed by
//! its arithmetic in Rust ([`Reducer`]).

use potamoi_formats::rit::{RitEntry, Vertices};

use super::entry;
use potamoi_march::streams::Visit;
use potamoi_march::tiling::{Holder, SampleLocation, Tiling};
use potamoi_reference::GatherTask;
use potamoi_reference::gathering_unit::Reducer;

/// Rows and entries of a table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Shape {
    pub(crate) channels: usize,
    pub(crate) vertices: Vertices,
    pub(crate) reducer: Reducer,
    /// Whether the unit returns unrounded sums.
    pub(crate) exact_sums: bool,
}

impl Shape {
    /// The corner bits of a complete entry.
    pub(crate) const fn whole(&self) -> u8 {
        u8::MAX >> (8 - self.vertices.count())
    }
}

/// A sample in one of the MVoxels that hold vertices of its cell.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Part {
    /// The corners in this MVoxel, by bit.
    pub(crate) held: u8,
    /// The entry; corners that are not here have row 0.
    pub(crate) entry: RitEntry,
}

impl Part {
    /// The part of a sample that one of its holders has.
    pub(crate) fn of(
        tiling: &Tiling,
        place: &SampleLocation,
        holder: Holder,
        slot: u32,
        shape: &Shape,
    ) -> Self {
        let (rows, held) = tiling.part_rows(place, holder);
        let weight_bits = shape.reducer.weight_bits();
        Self {
            held: held & shape.whole(),
            entry: entry(slot, shape.vertices, place.fraction, weight_bits, rows),
        }
    }

    /// The entry for the unit: a corner outside the MVoxel has weight 0 and some row of the
    /// MVoxel.
    fn for_unit(&self, vertices: Vertices) -> RitEntry {
        let held = |v: usize| self.held >> v & 1 == 1;
        let mut entry = self.entry;
        let some = (0..vertices.count()).find(|v| held(*v)).unwrap_or_default();
        for v in (0..vertices.count()).filter(|v| !held(*v)) {
            (entry.rows[v], entry.weights[v]) = (entry.rows[some], 0);
        }
        entry
    }

    /// Adds its unrounded sums, one a channel. `rows` are those of its MVoxel.
    pub(crate) fn add_to(&self, sums: &mut [i64], rows: &[i16], shape: &Shape) {
        let entry = &self.entry;
        for (channel, sum) in sums.iter_mut().enumerate() {
            let held = (0..8).filter(|corner| self.held >> corner & 1 == 1);
            let row = |corner: usize| usize::from(entry.rows[corner]) * shape.channels;
            let terms = held.map(|v| (entry.weights[v], rows[row(v) + channel]));
            *sum += shape.reducer.sum(terms);
        }
    }
}

/// A visit of an MVoxel, part by part.
#[derive(Debug, Default)]
pub(crate) struct Load {
    /// The last row used.
    last: u16,
    whole: u64,
    split: u64,
    /// Entries for the unit.
    entries: Vec<RitEntry>,
}

impl Load {
    /// Adds a part; returns whether the unit gathers it.
    pub(crate) fn add(&mut self, part: &Part, shape: &Shape) -> bool {
        self.last = part.entry.rows.into_iter().fold(self.last, u16::max);
        let is_whole = part.held == shape.whole();
        self.whole += u64::from(is_whole);
        self.split += u64::from(!is_whole);
        let is_gathered = is_whole || shape.exact_sums;
        if is_gathered {
            self.entries.push(part.for_unit(shape.vertices));
        }
        is_gathered
    }

    /// The traffic, and the task if the unit gathers anything; `None` without parts. The MVoxel,
    /// whose rows are `rows`, is loaded up to the last row used.
    pub(crate) fn done(self, rows: &[i16], shape: &Shape) -> Option<(Visit, Option<GatherTask>)> {
        if self.whole + self.split == 0 {
            return None;
        }
        let &Shape {
            channels, vertices, ..
        } = shape;
        let used = usize::from(self.last) + 1;
        let visit = Visit {
            vertices,
            channels,
            rows: used as u64,
            whole: self.whole,
            split: self.split,
        };
        let task = (!self.entries.is_empty()).then(|| GatherTask {
            vertices,
            channels,
            rows: rows[..used * channels].to_vec(),
            entries: self.entries,
        });
        Some((visit, task))
    }
}
