//! Vertices that several MVoxels need: stored in each, or once.

use serde::Serialize;

use super::{MVoxels, Place};

/// How MVoxels share the vertices between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Halo {
    /// Stored in both.
    #[default]
    Shared,
    /// Stored once.
    Split,
}

impl MVoxels {
    /// The same vertices, cut with another halo.
    #[must_use]
    pub fn with_halo(&self, halo: Halo) -> Self {
        let mut made = Self {
            halo,
            counts: Self::counts_of(self.points, self.edge, halo),
            rows: vec![],
            ..self.clone()
        };
        let codes = self.codes();
        made.rows = (0..made.counts.iter().product())
            .map(|m| made.cut(m, &codes))
            .collect();
        made.occupied = vec![false; made.rows.len()];
        let [x, y, z] = self.points.map(|p| p - 1);
        for index in (0..x * y * z).filter(|i| self.cells[i / 64] >> (i % 64) & 1 == 1) {
            let cell = [index % x, index / x % y, index / (x * y)];
            let owner = made.number(cell.map(|c| c / made.stride()));
            made.occupied[owner] = true;
        }
        made
    }

    /// The codes of all vertices, x fastest.
    fn codes(&self) -> Vec<i16> {
        let [x, y, z] = self.points;
        let mut codes = Vec::with_capacity(x * y * z * self.channels);
        for vertex in 0..x * y * z {
            let at = [vertex % x, vertex / x % y, vertex / (x * y)];
            let mut index = [0; 3];
            for axis in 0..3 {
                index[axis] = (at[axis] / self.stride()).min(self.counts[axis] - 1);
            }
            let mvoxel = self.number(index);
            let local = [0, 1, 2].map(|axis| at[axis] - index[axis] * self.stride());
            let row = self.row(mvoxel, local) * self.channels;
            codes.extend_from_slice(&self.rows[mvoxel][row..][..self.channels]);
        }
        codes
    }

    /// The axes, by bit, along which the far vertices of a place's cell lie in
    /// the next MVoxel; none where faces are shared.
    #[must_use]
    pub fn straddles(&self, place: &Place) -> usize {
        (0..3)
            .filter(|axis| place.local[*axis] + 1 == self.edge)
            .fold(0, |bits, axis| bits | 1 << axis)
    }

    /// The MVoxels that hold vertices of a place's cell, and for each along which
    /// axes it lies behind the owner.
    pub fn holders(&self, place: &Place) -> impl Iterator<Item = (usize, usize)> + use<> {
        let across = self.straddles(place);
        let owner = place.mvoxel;
        let [x, y, _] = self.counts;
        let ahead = [1, x, x * y];
        let behind = (0..8usize).filter(move |bits| bits & !across == 0);
        behind.map(move |bits| {
            let next = (0..3).filter(|axis| bits >> axis & 1 == 1);
            (owner + next.map(|axis| ahead[axis]).sum::<usize>(), bits)
        })
    }

    /// Rows of the corners of a place's cell in one of its holders, and which
    /// corners are there, by bit. Those that are not have row 0.
    #[must_use]
    pub fn part_rows(&self, place: &Place, (mvoxel, behind): (usize, usize)) -> ([u16; 8], u8) {
        let across = self.straddles(place);
        let (mut rows, mut held) = ([0; 8], 0);
        for (corner, row) in rows.iter_mut().enumerate() {
            if corner & across != behind {
                continue;
            }
            held |= 1 << corner;
            let at = [0, 1, 2].map(|axis| match (across >> axis & 1, corner >> axis & 1) {
                (1, 1) => 0,
                (_, bit) => place.local[axis] + bit,
            });
            *row = self.row(mvoxel, at) as u16;
        }
        (rows, held)
    }
}
