//! What a table's gathers exchange with memory, without the gathers.

use std::collections::HashMap;

use glam::DVec3;

use super::CodedTable;
use super::scattered::{Held, ScatteredTable};
use potamoi_march::streams::{Streams, Visit};
use potamoi_march::tiling::{Place, Tiling};

/// Samples of a batch, counted as they come.
pub struct BatchCount<'a> {
    table: &'a CodedTable,
    /// MVoxels that are loaded once, where the table streams.
    loaded: Option<Tally>,
    /// Rows that samples need, where the table may be gathered so.
    fetched: Option<Fetched<'a>>,
}

/// What the gathers of a batch come to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counted {
    /// MVoxels, or tasks where rows are fetched as samples need them.
    pub tasks: u64,
    /// Entries, of a sample one in each MVoxel that holds vertices of it.
    pub entries: u64,
    /// Their bytes.
    pub streams: Streams,
    /// Of the bytes of MVoxels, those that are fetched row by row.
    pub scattered: u64,
}

/// A task whose samples join it as they come, and those before it.
struct Fetched<'a> {
    table: &'a ScatteredTable,
    held: Held,
    entries: u64,
    counted: Counted,
}

/// What samples do to MVoxels, by the number of each. Those of a ray mostly follow
/// one another in one MVoxel.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tally {
    touched: HashMap<usize, Touched>,
    current: Option<(usize, Touched)>,
}

/// What samples do to one MVoxel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(crate) struct Touched {
    /// The last row that is read.
    pub(crate) last: u64,
    /// Entries of samples that have all their vertices here.
    pub(crate) whole: u64,
    /// Entries of samples that do not.
    pub(crate) split: u64,
}

impl Touched {
    /// One entry that has all its vertices.
    pub(super) const fn whole(last: u64) -> Self {
        Self {
            last,
            whole: 1,
            split: 0,
        }
    }

    fn and(self, other: Self) -> Self {
        Self {
            last: self.last.max(other.last),
            whole: self.whole + other.whole,
            split: self.split + other.split,
        }
    }
}

impl Tally {
    /// Notes entries in an MVoxel.
    pub(crate) fn add(&mut self, mvoxel: usize, more: Touched) {
        match &mut self.current {
            Some((key, sum)) if *key == mvoxel => *sum = sum.and(more),
            current => {
                let before = current.replace((mvoxel, more));
                self.put(before);
            }
        }
    }

    /// Notes the entries of a sample: one in each MVoxel that holds vertices of
    /// it.
    pub(crate) fn touch(&mut self, tiling: &Tiling, place: &Place) {
        let split = u64::from(tiling.straddles(place) != 0);
        for holder in tiling.holders(place) {
            let more = Touched {
                last: tiling.last_row(place, holder).into(),
                whole: 1 - split,
                split,
            };
            self.add(holder.mvoxel, more);
        }
    }

    fn put(&mut self, of: Option<(usize, Touched)>) {
        if let Some((key, more)) = of {
            let to = self.touched.entry(key).or_default();
            *to = to.and(more);
        }
    }

    /// All MVoxels, in no order.
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

    /// Ends the task of the rows that are held.
    fn end(&mut self, of: &CodedTable) {
        if self.entries == 0 {
            return;
        }
        let rows = self.held.count() as u64;
        self.counted.visit(of, rows, self.entries, 0);
        self.held.clear();
        self.entries = 0;
    }
}

impl Counted {
    fn visit(&mut self, of: &CodedTable, rows: u64, whole: u64, split: u64) {
        let visit = Visit {
            vertices: of.shape.vertices,
            channels: of.shape.channels,
            rows,
            whole,
            split,
        };
        self.tasks += 1;
        self.entries += whole + split;
        self.streams.visit(&visit, of.unit_streams);
    }
}

impl<'a> BatchCount<'a> {
    /// A batch without samples of a table.
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

    /// Takes the next sample, at a place in vertices.
    pub fn sample(&mut self, place: DVec3) {
        if let Some(tally) = &mut self.loaded {
            self.table.touch(place, tally);
        }
        if let Some(fetched) = &mut self.fetched {
            fetched.sample(self.table, place);
        }
    }

    /// What the batch came to, in the order of fewer rows where there are two
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
                counted.visit(table, touched.last + 1, touched.whole, touched.split);
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
