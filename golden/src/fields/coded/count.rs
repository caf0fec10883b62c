//! What a table's gathers exchange with memory, without the gathers.

use std::collections::HashMap;

use glam::DVec3;
use potamoi_formats::config::Config;
use potamoi_formats::rit::Vertices;

use super::CodedTable;
use super::scattered::Held;
use crate::streams::{RitReads, Streams, Visit};

/// Samples of a batch, counted as they come.
pub struct BatchCount<'a> {
    table: &'a CodedTable,
    reads: RitReads,
    state: State,
    counted: Counted,
}

/// What the gathers of a batch come to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counted {
    /// Tasks.
    pub tasks: u64,
    /// Their entries.
    pub entries: u64,
    /// Their bytes.
    pub streams: Streams,
}

enum State {
    /// Of MVoxels that are loaded once.
    Loaded(Tally<usize>),
    /// Rows, and entries, of a task whose samples join it as they come.
    Fetched(Held, u64),
}

/// What samples do to MVoxels, by the number of each. Those of a ray mostly follow
/// one another in one MVoxel.
#[derive(Debug, Clone)]
pub(crate) struct Tally<K> {
    touched: HashMap<K, Touched>,
    current: Option<(K, Touched)>,
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
    fn and(self, other: Self) -> Self {
        Self {
            last: self.last.max(other.last),
            whole: self.whole + other.whole,
            split: self.split + other.split,
        }
    }
}

impl<K: Copy + Eq + std::hash::Hash> Tally<K> {
    pub(crate) fn new() -> Self {
        Self {
            touched: HashMap::new(),
            current: None,
        }
    }

    /// Notes entries in an MVoxel.
    pub(crate) fn add(&mut self, mvoxel: K, more: Touched) {
        match &mut self.current {
            Some((key, sum)) if *key == mvoxel => *sum = sum.and(more),
            current => {
                let before = current.replace((mvoxel, more));
                self.put(before);
            }
        }
    }

    fn put(&mut self, of: Option<(K, Touched)>) {
        if let Some((key, more)) = of {
            let to = self.touched.entry(key).or_default();
            *to = to.and(more);
        }
    }

    /// All MVoxels, in no order.
    pub(crate) fn done(mut self) -> HashMap<K, Touched> {
        let last = self.current.take();
        self.put(last);
        self.touched
    }
}

impl<'a> BatchCount<'a> {
    /// A batch without samples of a table, gathered by the unit that `config`
    /// describes.
    #[must_use]
    pub fn new(table: &'a CodedTable, config: &Config) -> Self {
        let state = match table {
            CodedTable::Scattered(table) => State::Fetched(table.held(), 0),
            CodedTable::Streaming(_) | CodedTable::Tree(_) => State::Loaded(Tally::new()),
        };
        Self {
            table,
            reads: RitReads::of(config),
            state,
            counted: Counted::default(),
        }
    }

    /// Takes the next sample, at a place in vertices.
    pub fn sample(&mut self, place: DVec3) {
        let mut load = |reached: Option<(usize, u16)>| {
            if let (State::Loaded(tally), Some((mvoxel, row))) = (&mut self.state, reached) {
                let more = Touched {
                    last: row.into(),
                    whole: 1,
                    split: 0,
                };
                tally.add(mvoxel, more);
            }
        };
        match self.table {
            CodedTable::Streaming(table) => load(Some(table.reach(place))),
            CodedTable::Tree(table) => load(table.reach(place)),
            CodedTable::Scattered(table) => {
                let (rows, _) = table.rows(place);
                let rows = &rows[..table.vertices().count()];
                if let State::Fetched(held, _) = &self.state
                    && !held.fits(rows)
                {
                    self.end();
                }
                if let State::Fetched(held, entries) = &mut self.state {
                    for row in rows {
                        held.local(*row, |_| ());
                    }
                    *entries += 1;
                }
            }
        }
    }

    /// Ends the task of rows that are held.
    fn end(&mut self) {
        if let State::Fetched(held, entries) = &mut self.state
            && *entries > 0
        {
            let (rows, whole) = (held.count() as u64, *entries);
            held.clear();
            *entries = 0;
            self.visit(rows, whole);
        }
    }

    fn visit(&mut self, rows: u64, whole: u64) {
        let vertices = match self.table {
            CodedTable::Streaming(table) => table.vertices(),
            CodedTable::Scattered(table) => table.vertices(),
            CodedTable::Tree(_) => Vertices::One,
        };
        let visit = Visit {
            vertices,
            channels: self.table.channels(),
            rows,
            whole,
            split: 0,
        };
        self.counted.tasks += 1;
        self.counted.entries += whole;
        self.counted.streams.visit(&visit, self.reads);
    }

    /// What the batch came to.
    #[must_use]
    pub fn done(mut self) -> Counted {
        self.end();
        let empty = State::Loaded(Tally::new());
        if let State::Loaded(tally) = std::mem::replace(&mut self.state, empty) {
            for touched in tally.done().into_values() {
                self.visit(touched.last + 1, touched.whole);
            }
        }
        self.counted
    }
}
