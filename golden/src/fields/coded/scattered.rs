//! A hashed table, whose vertices lie anywhere: the order of the samples is
//! kept, and rows are fetched one by one as samples need them.

use std::collections::HashMap;

use potamoi_formats::rit::Vertices;

use super::{Gathers, Located, cell, entry, part, vertices};
use crate::fields::{FieldError, Table};
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

    /// Samples join a task as long as the rows that they need fit the MVoxel
    /// feature table; a row is fetched once a task.
    pub(super) fn gathers(&self, samples: &[Located], weight_bits: u32) -> Gathers {
        let count = self.vertices.count();
        let mut tasks = vec![];
        let mut task = self.empty();
        let mut held: HashMap<usize, u16> = HashMap::new();
        for at in samples {
            let (low, fraction) = cell(self.points, at.place);
            let row = |corner: usize| {
                let vertex = [0, 1, 2].map(|axis| low[axis] + (corner >> axis & 1));
                Table::hashed_row(vertex, self.entries)
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
            let local = |corner: usize| {
                let row = corners[corner];
                let next = held.len() as u16;
                *held.entry(row).or_insert_with(|| {
                    let values = &self.codes[row * self.channels..][..self.channels];
                    task.rows.extend_from_slice(values);
                    next
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
