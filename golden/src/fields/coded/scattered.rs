//! A hashed table, whose vertices lie anywhere: the order of the samples is
//! kept, and rows are fetched one by one as samples need them.

use std::collections::HashMap;
use std::sync::Arc;

use super::visit::{Gathers, Shape};
use super::{Located, entry, part};
use crate::fields::{FieldError, HashUnit, Table};
use crate::tiling::cell;
use crate::units::GatherTask;

/// A hashed table as codes.
#[derive(Debug, Clone, PartialEq)]
pub struct ScatteredTable {
    points: [usize; 3],
    unit: HashUnit,
    shape: Shape,
    codes: Arc<[i16]>,
    /// Rows that are held at a time.
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

    pub(super) const fn channels(&self) -> usize {
        self.shape.channels
    }

    /// Samples join a task as long as the rows that they need fit the MVoxel
    /// feature table; a row is fetched once a task.
    pub(super) fn gathers(&self, samples: &[Located], weight_bits: u32) -> Gathers {
        let (count, channels) = (self.shape.vertices.count(), self.shape.channels);
        let entries = self.codes.len() / channels;
        let mut tasks = vec![];
        let mut task = self.empty();
        let mut held: HashMap<usize, u16> = HashMap::new();
        for at in samples {
            let (low, fraction) = cell(self.points, at.place.to_array());
            let row = |corner: usize| {
                let vertex = [0, 1, 2].map(|axis| low[axis] + (corner >> axis & 1));
                Table::hashed_row(self.unit, vertex, entries)
            };
            let mut rows: Vec<usize> = (0..count).map(row).collect();
            let corners = rows.clone();
            rows.sort_unstable();
            rows.dedup();
            let missing = rows.iter().filter(|row| !held.contains_key(row)).count();
            if held.len() + missing > self.held {
                tasks.push(std::mem::replace(&mut task, self.empty()));
                held.clear();
            }
            let mut local = [0; 8];
            for (local, row) in local.iter_mut().zip(corners) {
                let next = held.len() as u16;
                *local = *held.entry(row).or_insert_with(|| {
                    let values = &self.codes[row * channels..][..channels];
                    task.rows.extend_from_slice(values);
                    next
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
