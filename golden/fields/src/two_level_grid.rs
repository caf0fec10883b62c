//! A two-level tree over a volume: each non-empty coarse cell has a node, a cube of fine cells.

use glam::DVec3;
use rayon::prelude::*;

/// Marks a coarse cell without a node.
const NONE: u32 = u32::MAX;

/// The nodes of coarse cells, and the order of their fine cells.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct Nodes {
    /// Number of coarse cells along each axis.
    cells: [usize; 3],
    /// Fine cells an edge of a coarse cell.
    fine: usize,
    /// The node of each coarse cell, x fastest.
    node: Vec<u32>,
    count: usize,
}

impl Nodes {
    /// Nodes for the coarse cells that are `filled`, in their order, x fastest.
    #[must_use]
    pub fn new(cells: [usize; 3], fine: usize, filled: impl Fn([usize; 3]) -> bool + Sync) -> Self {
        let all = (0..cells.iter().product::<usize>()).into_par_iter();
        let node = all.map(|i| {
            let cell = [
                i % cells[0],
                i / cells[0] % cells[1],
                i / (cells[0] * cells[1]),
            ];
            if filled(cell) { 0 } else { NONE }
        });
        let mut node: Vec<u32> = node.collect();
        let mut count = 0;
        for number in node.iter_mut().filter(|number| **number != NONE) {
            *number = count;
            count += 1;
        }
        Self {
            cells,
            fine,
            node,
            count: count as usize,
        }
    }

    /// Number of coarse cells along each axis.
    #[must_use]
    pub const fn cells(&self) -> [usize; 3] {
        self.cells
    }

    /// Fine cells an edge of a coarse cell.
    #[must_use]
    pub const fn fine(&self) -> usize {
        self.fine
    }

    /// Number of fine cells of the volume along each axis.
    #[must_use]
    pub fn points(&self) -> [usize; 3] {
        self.cells.map(|cells| cells * self.fine)
    }

    /// Number of rows: fine cells of all nodes.
    #[must_use]
    pub const fn rows(&self) -> usize {
        self.count * self.fine.pow(3)
    }

    /// The first row of a coarse cell's node, if it has one.
    #[must_use]
    pub fn first(&self, [x, y, z]: [usize; 3]) -> Option<usize> {
        let node = self.node[x + self.cells[0] * (y + self.cells[1] * z)];
        (node != NONE).then(|| node as usize * self.fine.pow(3))
    }

    /// The row of a fine cell within its node.
    #[must_use]
    pub fn local(&self, fine: [usize; 3]) -> usize {
        let [x, y, z] = fine.map(|i| i % self.fine);
        x + self.fine * (y + self.fine * z)
    }

    /// The row of a fine cell, if its coarse cell has a node.
    #[must_use]
    pub fn row(&self, fine: [usize; 3]) -> Option<usize> {
        let first = self.first(fine.map(|i| i / self.fine))?;
        Some(first + self.local(fine))
    }

    /// The fine cell that contains a position, which is first rounded to 12 fraction bits and
    /// clamped to the volume.
    #[must_use]
    pub fn cell(&self, place: DVec3) -> [usize; 3] {
        let points = self.points();
        [0, 1, 2].map(|axis| {
            let code = potamoi_march::tiling::position_code(place[axis]).max(0) as u64;
            let cell = code >> potamoi_reference::weights::FRACTION_BITS;
            cell.min(points[axis] as u64 - 1) as usize
        })
    }
}
