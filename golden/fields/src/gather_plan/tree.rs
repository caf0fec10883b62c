//! The fine cells of a tree in MVoxels: cubes of as many coarse cells as fit. Coarse cells without
//! a node take no rows.

use glam::DVec3;
use potamoi_formats::rit::{MAX_VERTICES, RitEntry};

use super::part::{Part, Shape};
use super::visit::{Gathers, Placed};
use super::{Located, Tally, Touched, part};
use crate::{FieldError, Nodes};
use potamoi_march::tiling::{Halo, Tiling};

/// A quantised tree in MVoxels.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeTable {
    nodes: Nodes,
    shape: Shape,
    /// Tiling of fine cells, none of which is shared.
    tiling: Tiling,
    /// Rows of each MVoxel: the nodes of its coarse cells, x fastest.
    rows: Vec<Vec<i16>>,
    /// For each coarse cell, the first row of its node in the MVoxel, x fastest.
    first: Vec<u16>,
}

impl TreeTable {
    pub(super) fn new(
        nodes: &Nodes,
        codes: Vec<i16>,
        shape: Shape,
        rows: usize,
    ) -> Result<Self, FieldError> {
        let volume = nodes.fine().pow(3);
        let fits = (1..=40usize).take_while(|edge| edge.pow(3) * volume <= rows);
        let Some(edge) = fits.last() else {
            let expected = format!("{volume} rows or more, for a node's fine cells");
            return Err(part("mvoxel.rows", rows.to_string(), expected));
        };
        let cells = nodes.cells();
        let channels = shape.channels;
        let tiling = Tiling::new(
            cells.map(|cells| cells * nodes.fine()),
            [edge * nodes.fine(); 3],
            Halo::Split,
        );
        let mut made = Self {
            nodes: nodes.clone(),
            shape,
            tiling,
            rows: vec![vec![]; tiling.count()],
            first: vec![0; cells.iter().product()],
        };
        for i in 0..made.first.len() {
            let cell = [
                i % cells[0],
                i / cells[0] % cells[1],
                i / (cells[0] * cells[1]),
            ];
            if let Some(row) = nodes.first(cell) {
                let (to, _) = tiling.owner(cell.map(|i| i * nodes.fine()));
                made.first[i] = (made.rows[to].len() / channels) as u16;
                let own = &codes[row * channels..][..volume * channels];
                made.rows[to].extend_from_slice(own);
            }
        }
        Ok(made)
    }

    /// The MVoxel of a position in fine cells, and the row that is read; `None` without a node.
    fn reach(&self, place: DVec3) -> Option<(usize, u16)> {
        let fine = self.nodes.cell(place);
        let cell = fine.map(|i| i / self.nodes.fine());
        self.nodes.first(cell)?;
        let (mvoxel, _) = self.tiling.owner(fine);
        let cells = self.nodes.cells();
        let first = self.first[cell[0] + cells[0] * (cell[1] + cells[1] * cell[2])];
        Some((mvoxel, first + self.nodes.local(fine) as u16))
    }

    /// Counts what a sample at a position reads.
    pub(super) fn touch(&self, place: DVec3, tally: &mut Tally) {
        if let Some((mvoxel, row)) = self.reach(place) {
            tally.add(mvoxel, Touched::whole(row.into()));
        }
    }

    pub(super) fn gathers(&self, eye: DVec3, samples: &[Located]) -> Gathers {
        let seen = self.tiling.distances_from(eye.to_array());
        let place = |(sample, at): (u32, &Located)| {
            let (mvoxel, row) = self.reach(at.place)?;
            let mut rows = [0; MAX_VERTICES];
            rows[0] = row;
            Some(Placed {
                distance: seen.distance(self.tiling.index(mvoxel)),
                mvoxel,
                sample,
                part: Part {
                    held: self.shape.whole(),
                    entry: RitEntry {
                        slot: at.slot,
                        rows,
                        weights: [0; MAX_VERTICES],
                    },
                },
            })
        };
        let placed = (0..).zip(samples).filter_map(place).collect();
        Gathers::visiting(placed, self.shape, |mvoxel| &self.rows[mvoxel])
    }
}
