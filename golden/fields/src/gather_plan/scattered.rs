//! A hashed table whose vertices lie anywhere: samples keep their order, and rows are fetched one
//! by one as samples need them.

use std::sync::Arc;

use glam::DVec3;
use potamoi_formats::rit::MAX_VERTICES;

use super::part::Shape;
use super::visit::Gathers;
use super::{Located, entry, part};
use crate::{FieldError, HashUnit};
use potamoi_march::tiling::cell;
use potamoi_reference::GatherTask;

/// A quantised hashed table.
#[derive(Debug, Clone, PartialEq)]
pub struct ScatteredTable {
    points: [usize; 3],
    unit: HashUnit,
    shape: Shape,
    codes: Arc<[i16]>,
    /// Number of rows in memory at a time.
    held: usize,
}

impl ScatteredTable {
    pub(super) fn new(
        points: [usize; 3],
        unit: HashUnit,
        shape: Shape,
        codes: &Arc<[i16]>,
        rows: usize,
    ) -> Result<Self, FieldError> {
        let count = shape.vertices.count();
        if rows < count {
            let expected = format!("{count} rows or more, for a sample's vertices");
            return Err(part("mvoxel.rows", rows.to_string(), expected));
        }
        Ok(Self {
            points,
            unit,
            shape,
            codes: codes.clone(),
            held: rows,
        })
    }

    /// Number of rows that vertices share.
    fn entries(&self) -> usize {
        self.codes.len() / self.shape.channels
    }

    /// The rows of a sample, corner after corner, and its position within the cell.
    pub(super) fn rows(&self, place: DVec3) -> ([usize; MAX_VERTICES], [u16; 3]) {
        let (low, fraction) = cell(self.points, place.to_array());
        let (count, entries) = (self.shape.vertices.count(), self.entries());
        let mut rows = [0; MAX_VERTICES];
        for (corner, row) in rows.iter_mut().enumerate().take(count) {
            let vertex = [0, 1, 2].map(|axis| low[axis] + (corner >> axis & 1));
            *row = self.unit.row(vertex, entries);
        }
        (rows, fraction)
    }

    /// An empty set of rows.
    pub(super) fn held(&self) -> RowSet {
        RowSet::new(self.held)
    }

    /// The tasks of samples. A sample joins the current task if its rows fit the MVoxel feature
    /// table; each row is fetched once a task.
    pub(super) fn gathers(&self, samples: &[Located], weight_bits: u32) -> Gathers {
        let (count, channels) = (self.shape.vertices.count(), self.shape.channels);
        let mut tasks = vec![];
        let mut task = self.empty();
        let mut held = self.held();
        for at in samples {
            let (rows, fraction) = self.rows(at.place);
            if !held.fits(&rows[..count]) {
                tasks.push(std::mem::replace(&mut task, self.empty()));
                held.clear();
            }
            let mut local = [0; MAX_VERTICES];
            for (local, row) in local.iter_mut().zip(&rows[..count]) {
                *local = held.local(*row, |row| {
                    let values = &self.codes[row * channels..][..channels];
                    task.rows.extend_from_slice(values);
                });
            }
            let made = entry(at.slot, self.shape.vertices, fraction, weight_bits, local);
            task.entries.push(made);
        }
        if !task.entries.is_empty() {
            tasks.push(task);
        }
        Gathers::row_by_row(tasks, samples.len())
    }

    fn empty(&self) -> GatherTask {
        GatherTask {
            vertices: self.shape.vertices,
            channels: self.shape.channels,
            rows: vec![],
            entries: vec![],
        }
    }
}

/// Rows of a table held by a task.
pub(super) struct RowSet {
    most: usize,
    /// Number of the task.
    task: u32,
    /// A hash table with linear probing, of more than twice as many slots as rows, a power of two.
    /// A slot holds the last task that used it, a row, and the position of the row.
    slots: Vec<(u32, u32, u16)>,
    count: usize,
}

impl RowSet {
    /// A set of at most `most` rows.
    fn new(most: usize) -> Self {
        Self {
            most,
            task: 1,
            slots: vec![(0, 0, 0); (2 * most).next_power_of_two()],
            count: 0,
        }
    }

    /// Number of rows held.
    pub(super) const fn count(&self) -> usize {
        self.count
    }

    /// The slot of a row, or the one that it would take.
    fn slot(&self, row: usize) -> usize {
        let last = self.slots.len() - 1;
        // The golden ratio times 2^64: neighbours lie apart.
        let mixed = (row as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32;
        let mut at = mixed as usize & last;
        while self.slots[at].0 == self.task && self.slots[at].1 as usize != row {
            at = (at + 1) & last;
        }
        at
    }

    /// Whether all rows that are not held fit, too.
    pub(super) fn fits(&self, rows: &[usize]) -> bool {
        let is_new = |i: &usize| {
            self.slots[self.slot(rows[*i])].0 != self.task && !rows[..*i].contains(&rows[*i])
        };
        self.count + (0..rows.len()).filter(is_new).count() <= self.most
    }

    /// The position of a row; `fetch` is called if it was not held.
    pub(super) fn local(&mut self, row: usize, fetch: impl FnOnce(usize)) -> u16 {
        let slot = self.slot(row);
        if self.slots[slot].0 != self.task {
            self.slots[slot] = (self.task, row as u32, self.count as u16);
            self.count += 1;
            fetch(row);
        }
        self.slots[slot].2
    }

    /// Releases all rows for the next task.
    pub(super) fn clear(&mut self) {
        self.task += 1;
        self.count = 0;
    }
}
