//! A dense table in MVoxels ([`potamoi_march::tiling`]), visited in the order of their
//! distance from the camera's.

use glam::DVec3;
use potamoi_formats::rit::Vertices;

use super::visit::{Gathers, Placed, Shape};
use super::{Located, Tally, entry, part};
use crate::FieldError;
use potamoi_march::tiling::{Halo, Tiling, cell, edges};

/// A quantised dense table in MVoxels. Flat tables have one vertex along their last axes.
#[derive(Debug, Clone, PartialEq)]
pub struct MVoxelTable {
    tiling: Tiling,
    shape: Shape,
    /// Rows of each MVoxel, channels fastest, then the first axis.
    rows: Vec<Vec<i16>>,
}

impl MVoxelTable {
    pub(super) fn new(
        points: [usize; 3],
        shape: Shape,
        codes: &[i16],
        rows: u32,
        halo: Halo,
    ) -> Result<Self, FieldError> {
        let Some(edge) = edges(points, rows) else {
            let vertices = shape.vertices.count();
            let expected = format!("{vertices} rows or more, for a cell's vertices");
            return Err(part("mvoxel.rows", rows.to_string(), expected));
        };
        let tiling = Tiling::new(points, edge, halo);
        let all = 0..tiling.count();
        Ok(Self {
            tiling,
            shape,
            rows: all.map(|m| tiling.cut(m, codes, shape.channels)).collect(),
        })
    }

    /// Vertices an entry.
    #[must_use]
    pub const fn vertices(&self) -> Vertices {
        self.shape.vertices
    }

    #[cfg(test)]
    pub(super) const fn tiling(&self) -> &Tiling {
        &self.tiling
    }

    /// Rows of an MVoxel, channels side by side, the first axis fastest.
    #[must_use]
    pub fn rows(&self, mvoxel: usize) -> &[i16] {
        &self.rows[mvoxel]
    }

    /// Counts what a sample at a position reads.
    pub(super) fn touch(&self, place: DVec3, tally: &mut Tally) {
        let (low, fraction) = cell(self.tiling.points(), place.to_array());
        tally.touch(&self.tiling, &self.tiling.place(low, fraction));
    }

    pub(super) fn gathers(&self, eye: DVec3, samples: &[Located], weight_bits: u32) -> Gathers {
        let points = self.tiling.points();
        let placed = placed(&self.tiling, points, self.shape, eye, samples, weight_bits);
        Gathers::visiting(placed, self.shape, |mvoxel| &self.rows[mvoxel])
    }
}

/// The entries of samples in each MVoxel that holds vertices of their cells. Positions are clamped
/// to `points`, which the MVoxels may exceed.
pub(super) fn placed(
    tiling: &Tiling,
    points: [usize; 3],
    shape: Shape,
    eye: DVec3,
    samples: &[Located],
    weight_bits: u32,
) -> Vec<Placed> {
    let seen = tiling.distances_from(eye.to_array());
    let mut placed = Vec::with_capacity(samples.len());
    for (sample, at) in (0..).zip(samples) {
        let (low, fraction) = cell(points, at.place.to_array());
        let place = tiling.place(low, fraction);
        for holder in tiling.holders(&place) {
            let (rows, held) = tiling.part_rows(&place, holder);
            placed.push(Placed {
                distance: seen.distance(tiling.index(holder.mvoxel)),
                mvoxel: holder.mvoxel,
                sample,
                held: held & shape.whole(),
                entry: entry(at.slot, shape.vertices, fraction, weight_bits, rows),
            });
        }
    }
    placed
}
