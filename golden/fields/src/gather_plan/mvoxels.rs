//! A dense table in MVoxels ([`potamoi_march::tiling`]), visited in the order of their
//! distance from the camera's.

use glam::DVec3;
use potamoi_formats::rit::Vertices;

use super::part::{Part, Shape};
use super::visit::{Gathers, Placed};
use super::{Located, Tally, part};
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
        Ok(Self::cut(Tiling::new(points, edge, halo), shape, codes))
    }

    /// Cuts the codes of all vertices, channels fastest, then the first axis.
    pub(crate) fn cut(tiling: Tiling, shape: Shape, codes: &[i16]) -> Self {
        let all = 0..tiling.count();
        Self {
            tiling,
            shape,
            rows: all.map(|m| tiling.cut(m, codes, shape.channels)).collect(),
        }
    }

    /// Vertices an entry.
    #[must_use]
    pub const fn vertices(&self) -> Vertices {
        self.shape.vertices
    }

    /// The division into MVoxels.
    pub(crate) const fn tiling(&self) -> &Tiling {
        &self.tiling
    }

    /// Rows and entries.
    pub(crate) const fn shape(&self) -> &Shape {
        &self.shape
    }

    /// The codes of all vertices, channels fastest, then the first axis.
    pub(crate) fn codes(&self) -> Vec<i16> {
        let ([nx, ny, nz], channels) = (self.tiling.points(), self.shape.channels);
        let mut codes = vec![0; nx * ny * nz * channels];
        for (mvoxel, rows) in self.rows.iter().enumerate() {
            let [x, y, z] = self.tiling.first(mvoxel);
            let [wide, high, _] = self.tiling.extent(mvoxel);
            for (line, own) in rows.chunks_exact(wide * channels).enumerate() {
                let start = x + nx * (y + line % high + ny * (z + line / high));
                codes[start * channels..][..own.len()].copy_from_slice(own);
            }
        }
        codes
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

    pub(super) fn gathers(&self, eye: DVec3, samples: &[Located]) -> Gathers {
        let points = self.tiling.points();
        let placed = placed(&self.tiling, points, self.shape, eye, samples);
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
) -> Vec<Placed> {
    let seen = tiling.distances_from(eye.to_array());
    let mut placed = Vec::with_capacity(samples.len());
    for (sample, at) in (0..).zip(samples) {
        let (low, fraction) = cell(points, at.place.to_array());
        let place = tiling.place(low, fraction);
        for holder in tiling.holders(&place) {
            placed.push(Placed {
                distance: seen.distance(tiling.index(holder.mvoxel)),
                mvoxel: holder.mvoxel,
                sample,
                part: Part::of(tiling, &place, holder, at.slot, &shape),
            });
        }
    }
    placed
}
