//! The fine cells of a tree in MVoxels: cubes of as many coarse cells as have
//! their rows in one, of which those without a node take none.

use glam::DVec3;
use potamoi_formats::rit::{MAX_VERTICES, RitEntry, Vertices};

use super::{Gathers, Located, Placed, index_of, part, visit};
use crate::fields::{FieldError, Nodes};
use crate::units::GatherTask;

/// A tree as codes in MVoxels.
#[derive(Debug, Clone, PartialEq)]
pub struct TreeTable {
    nodes: Nodes,
    channels: usize,
    /// Coarse cells an edge of an MVoxel.
    edge: usize,
    /// MVoxels along each axis.
    counts: [usize; 3],
    /// Rows of each MVoxel: of the nodes of its coarse cells, x fastest.
    rows: Vec<Vec<i16>>,
    /// The first row in its MVoxel of each coarse cell's node, x fastest.
    first: Vec<u16>,
}

impl TreeTable {
    pub(super) fn new(
        nodes: &Nodes,
        codes: Vec<i16>,
        channels: usize,
        rows: usize,
    ) -> Result<Self, FieldError> {
        let volume = nodes.fine().pow(3);
        let fits = (1..=40usize).take_while(|edge| edge.pow(3) * volume <= rows);
        let Some(edge) = fits.last() else {
            let expected = format!("{volume} rows or more, for a node's fine cells");
            return Err(part("mvoxel.rows", rows.to_string(), expected));
        };
        let cells = nodes.cells();
        let counts = cells.map(|cells| cells.div_ceil(edge));
        let mut made = Self {
            nodes: nodes.clone(),
            channels,
            edge,
            counts,
            rows: vec![vec![]; counts.iter().product()],
            first: vec![0; cells.iter().product()],
        };
        for i in 0..made.first.len() {
            let cell = [
                i % cells[0],
                i / cells[0] % cells[1],
                i / (cells[0] * cells[1]),
            ];
            if let Some(row) = nodes.first(cell) {
                let to = made.mvoxel(cell);
                made.first[i] = (made.rows[to].len() / channels) as u16;
                let own = &codes[row * channels..][..volume * channels];
                made.rows[to].extend_from_slice(own);
            }
        }
        Ok(made)
    }

    pub(super) const fn channels(&self) -> usize {
        self.channels
    }

    /// The MVoxel of a coarse cell.
    fn mvoxel(&self, cell: [usize; 3]) -> usize {
        let [x, y, z] = cell.map(|i| i / self.edge);
        x + self.counts[0] * (y + self.counts[1] * z)
    }

    /// How far an MVoxel is from the one of the camera, which is at `eye` in
    /// fine cells.
    fn distance(&self, mvoxel: usize, eye: DVec3) -> u64 {
        let [x, y, _] = self.counts;
        let index = [mvoxel % x, mvoxel / x % y, mvoxel / (x * y)];
        let wide = self.edge * self.nodes.fine();
        let along = |axis: usize| index_of(eye[axis], wide).abs_diff(index[axis] as i64);
        along(0) + along(1) + along(2)
    }

    /// The MVoxel of a place in fine cells, and the row that is read; nothing
    /// where there is no node.
    pub(super) fn reach(&self, place: DVec3) -> Option<(usize, u16)> {
        let fine = self.nodes.cell(place);
        let cell = fine.map(|i| i / self.nodes.fine());
        self.nodes.first(cell)?;
        let cells = self.nodes.cells();
        let first = self.first[cell[0] + cells[0] * (cell[1] + cells[1] * cell[2])];
        Some((self.mvoxel(cell), first + self.nodes.local(fine) as u16))
    }

    pub(super) fn gathers(&self, eye: DVec3, samples: &[Located]) -> Gathers {
        let distances: Vec<u64> = (0..self.rows.len())
            .map(|mvoxel| self.distance(mvoxel, eye))
            .collect();
        let place = |(sample, at): (u32, &Located)| {
            let (mvoxel, row) = self.reach(at.place)?;
            let mut rows = [0; MAX_VERTICES];
            rows[0] = row;
            Some(Placed {
                distance: distances[mvoxel],
                mvoxel: mvoxel as u32,
                sample,
                entry: RitEntry {
                    slot: at.slot,
                    rows,
                    weights: [0; MAX_VERTICES],
                },
            })
        };
        visit((0..).zip(samples).filter_map(place).collect(), |same| {
            let last = same.iter().map(|e| e.entry.rows[0]).max();
            let used = (usize::from(last.unwrap_or_default()) + 1) * self.channels;
            GatherTask {
                vertices: Vertices::One,
                channels: self.channels,
                rows: self.rows[same[0].mvoxel as usize][..used].to_vec(),
                entries: same.iter().map(|e| e.entry).collect(),
            }
        })
    }
}
