//! Memory traffic of a table's gathers, counted without building them.

use std::collections::HashMap;

use glam::DVec3;
use potamoi_formats::rit::Vertices;

use super::CodedTable;
use super::scattered::{RowSet, ScatteredTable};
use potamoi_march::streams::{Streams, Visit};
use potamoi_march::tiling::{Holder, SampleLocation, Tiling};

/// The count of a batch, sample by sample.
pub struct BatchCount<'a> {
    table: &'a CodedTable,
    /// MVoxels loaded once, if the table streams.
    loaded: Option<Tally>,
    /// Rows fetched as samples need them, if the table may be gathered in that order.
    fetched: Option<Fetched<'a>>,
}

/// Counts of a batch.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counted {
    /// MVoxels, or tasks if rows are fetched as samples need them.
    pub tasks: u64,
    /// Entries: one for each sample and MVoxel that holds vertices of its cell.
    pub entries: u64,
    /// Bytes by stream.
    pub streams: Streams,
    /// MVoxel bytes that are fetched row by row.
    pub scattered: u64,
}

/// The current task, which samples join as they come, and the counts of earlier tasks.
struct Fetched<'a> {
    table: &'a ScatteredTable,
    held: RowSet,
    entries: u64,
    counted: Counted,
}

/// Reads of each MVoxel by number. Successive samples of a ray are mostly in the same MVoxel.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tally {
    touched: HashMap<usize, Touched>,
    current: Option<(usize, Touched)>,
}

/// Reads of one MVoxel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Touched {
    /// The last row read.
    pub(crate) last: u64,
    /// Entries of samples with all vertices in this MVoxel.
    pub(crate) whole: u64,
    /// Entries of samples with only some vertices in it.
    pub(crate) split: u64,
}

impl Touched {
    /// One entry with all its vertices.
    pub(super) const fn whole(last: u64) -> Self {
        Self {
            last,
            whole: 1,
            split: 0,
        }
    }

    /// The entry of a sample in one of its holders.
    pub(crate) fn of(tiling: &Tiling, place: &SampleLocation, holder: Holder) -> Self {
        let split = u64::from(tiling.straddles(place) != 0);
        Self {
            last: tiling.last_row(place, holder).into(),
            whole: 1 - split,
            split,
        }
    }

    /// The traffic, for an MVoxel that is loaded up to the last row read.
    pub(crate) const fn visit(self, vertices: Vertices, channels: usize) -> Visit {
        Visit {
            vertices,
            channels,
            rows: self.last + 1,
            whole: self.whole,
            split: self.split,
        }
    }

    pub(crate) fn and(self, other: Self) -> Self {
        Self {
            last: self.last.max(other.last),
            whole: self.whole + other.whole,
            split: self.split + other.split,
        }
    }
}

impl Tally {
    /// Adds entries to an MVoxel.
    pub(crate) fn add(&mut self, mvoxel: usize, more: Touched) {
        match &mut self.current {
            Some((key, sum)) if *key == mvoxel => *sum = sum.and(more),
            current => {
                let before = current.replace((mvoxel, more));
                self.put(before);
            }
        }
    }

    /// Adds the entries of a sample: one in each MVoxel that holds vertices of its cell.
    pub(crate) fn touch(&mut self, tiling: &Tiling, place: &SampleLocation) {
        for holder in tiling.holders(place) {
            self.add(holder.mvoxel, Touched::of(tiling, place, holder));
        }
    }

    fn put(&mut self, of: Option<(usize, Touched)>) {
        if let Some((key, more)) = of {
            let to = self.touched.entry(key).or_default();
            *to = to.and(more);
        }
    }

    /// All MVoxels, in no particular order.
    pub(crate) fn done(mut self) -> HashMap<usize, Touched> {
        let last = self.current.take();
        self.put(last);
        self.touched
    }
}

impl Fetched<'_> {
    fn sample(&mut self, of: &CodedTable, place: DVec3) {
        let (rows, _) = self.table.rows(place);
        let rows = &rows[..of.shape.vertices.count()];
        if !self.held.fits(rows) {
            self.end(of);
        }
        for row in rows {
            self.held.local(*row, |_| ());
        }
        self.entries += 1;
    }

    /// Ends the current task.
    fn end(&mut self, of: &CodedTable) {
        if self.entries == 0 {
            return;
        }
        let rows = self.held.count() as u64;
        let read = Touched {
            last: rows - 1,
            whole: self.entries,
            split: 0,
        };
        self.counted.visit(of, read);
        self.held.clear();
        self.entries = 0;
    }
}

impl Counted {
    fn visit(&mut self, of: &CodedTable, touched: Touched) {
        let visit = touched.visit(of.shape.vertices, of.shape.channels);
        self.tasks += 1;
        self.entries += visit.whole + visit.split;
        self.streams.visit(&visit, of.unit_streams);
    }
}

impl<'a> BatchCount<'a> {
    /// An empty batch.
    #[must_use]
    pub fn new(table: &'a CodedTable) -> Self {
        Self {
            table,
            loaded: table.streams().then(Tally::default),
            fetched: table.scattered().map(|table| Fetched {
                table,
                held: table.held(),
                entries: 0,
                counted: Counted::default(),
            }),
        }
    }

    /// Adds the next sample, at a position in vertices.
    pub fn sample(&mut self, place: DVec3) {
        if let Some(tally) = &mut self.loaded {
            self.table.touch(place, tally);
        }
        if let Some(fetched) = &mut self.fetched {
            fetched.sample(self.table, place);
        }
    }

    /// The counts of the batch, in the order with fewer rows if there are two
    /// ([`BlockTable`](super::BlockTable)).
    #[must_use]
    pub fn done(self) -> Counted {
        let table = self.table;
        let fetched = self.fetched.map(|mut fetched| {
            fetched.end(table);
            let counted = fetched.counted;
            Counted {
                scattered: counted.streams.mvoxels_read,
                ..counted
            }
        });
        let loaded = self.loaded.map(|tally| {
            let mut counted = Counted::default();
            for touched in tally.done().into_values() {
                counted.visit(table, touched);
            }
            counted
        });
        // Of equals the first.
        let either = [loaded, fetched].into_iter().flatten();
        either
            .min_by_key(|counted| counted.streams.mvoxels_read)
            .unwrap_or_default()
    }
}
