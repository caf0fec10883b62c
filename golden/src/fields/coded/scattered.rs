//! A hashed table, whose vertices lie anywhere: the order of the samples is
//! kept, and rows are fetched one by one as samples need them.

use glam::DVec3;
use potamoi_formats::rit::{MAX_VERTICES, Vertices};

use super::{Gathers, Located, cell, entry, part, vertices};
use crate::fields::{FieldError, Table, TableShape};
use crate::units::GatherTask;

/// A hashed table as codes.
#[derive(Debug, Clone, PartialEq)]
pub struct ScatteredTable {
    points: [usize; 3],
    /// Rows that vertices share.
    entries: usize,
    channels: usize,
    vertices: Vertices,
    codes: Vec<i16>,
    /// Rows that are held at a time.
    held: usize,
}

impl ScatteredTable {
    pub(super) fn new(table: &Table, codes: Vec<i16>, rows: usize) -> Result<Self, FieldError> {
        let vertices = vertices(table);
        if rows < vertices.count() {
            let expected = format!("{} rows or more, for a sample's vertices", vertices.count());
            return Err(part("mvoxel.rows", rows.to_string(), expected));
        }
        Ok(Self {
            points: table.points(),
            entries: codes.len() / table.channels(),
            channels: table.channels(),
            vertices,
            codes,
            held: rows,
        })
    }

    pub(super) const fn channels(&self) -> usize {
        self.channels
    }

    /// The rows of a sample, corner after corner, and how far through its cell it
    /// is.
    pub(super) fn rows(&self, place: DVec3) -> ([usize; MAX_VERTICES], [u16; 3]) {
        let (low, fraction) = cell(self.points, place);
        let mut rows = [0; MAX_VERTICES];
        for (corner, row) in rows.iter_mut().enumerate().take(self.vertices.count()) {
            let vertex = [0, 1, 2].map(|axis| low[axis] + (corner >> axis & 1));
            *row = TableShape::hashed_row(vertex, self.entries);
        }
        (rows, fraction)
    }

    /// Vertices an entry.
    pub(super) const fn vertices(&self) -> Vertices {
        self.vertices
    }

    /// Nothing held.
    pub(super) fn held(&self) -> Held {
        Held {
            most: self.held,
            task: 1,
            rows: vec![(0, 0); self.entries],
            count: 0,
        }
    }

    /// Samples join a task as long as the rows that they need fit the MVoxel
    /// feature table; a row is fetched once a task.
    pub(super) fn gathers(&self, samples: &[Located], weight_bits: u32) -> Gathers {
        let count = self.vertices.count();
        let mut tasks = vec![];
        let mut task = self.empty();
        let mut held = self.held();
        for at in samples {
            let (rows, fraction) = self.rows(at.place);
            if !held.fits(&rows[..count]) {
                tasks.push(std::mem::replace(&mut task, self.empty()));
                held.clear();
            }
            let local = |corner: usize| {
                held.local(rows[corner], |row| {
                    let values = &self.codes[row * self.channels..][..self.channels];
                    task.rows.extend_from_slice(values);
                })
            };
            let made = entry(at.slot, self.vertices, fraction, weight_bits, local);
            task.entries.push(made);
        }
        if !task.entries.is_empty() {
            tasks.push(task);
        }
        Gathers {
            tasks,
            samples: (0..samples.len() as u32).collect(),
        }
    }

    fn empty(&self) -> GatherTask {
        GatherTask {
            vertices: self.vertices,
            channels: self.channels,
            rows: vec![],
            entries: vec![],
        }
    }
}

/// Rows of a table that a task holds.
pub(super) struct Held {
    most: usize,
    /// The number of the task.
    task: u32,
    /// Of each row of the table, the last task that held it, and where.
    rows: Vec<(u32, u16)>,
    count: usize,
}

impl Held {
    /// Rows held.
    pub(super) const fn count(&self) -> usize {
        self.count
    }

    /// Whether those of these rows that are not held fit, too.
    pub(super) fn fits(&self, rows: &[usize]) -> bool {
        let is_new =
            |i: &usize| self.rows[rows[*i]].0 != self.task && !rows[..*i].contains(&rows[*i]);
        self.count + (0..rows.len()).filter(is_new).count() <= self.most
    }

    /// Where a row is held; `fetch` is told if it was not.
    pub(super) fn local(&mut self, row: usize, fetch: impl FnOnce(usize)) -> u16 {
        let (task, local) = &mut self.rows[row];
        if *task != self.task {
            (*task, *local) = (self.task, self.count as u16);
            self.count += 1;
            fetch(row);
        }
        *local
    }

    /// Lets go of all rows, for the next task.
    pub(super) fn clear(&mut self) {
        self.task += 1;
        self.count = 0;
    }
}
