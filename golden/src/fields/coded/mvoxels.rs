//! A dense table in MVoxels.
//!
//! MVoxels of volumes are cubes, those of planes rectangles of twice as many
//! vertices along the faster axis or as many (32 x 16 with 512 rows), those of
//! lines take all rows. They follow one another at a stride of one vertex less,
//! so that every sample has one owner.
//!
//! They are visited in the order of their distance from the camera's, by the
//! sum of their indices' distances, which grows along every ray.

use glam::DVec3;
use potamoi_formats::rit::{RitEntry, Vertices};

use super::{Gathers, Located, Placed, cell, entry, index_of, part, vertices, visit};
use crate::fields::{FieldError, Table};
use crate::units::GatherTask;

/// A dense table as codes in MVoxels. Flat tables have one vertex along their
/// last axes.
#[derive(Debug, Clone, PartialEq)]
pub struct MVoxelTable {
    points: [usize; 3],
    edge: [usize; 3],
    counts: [usize; 3],
    channels: usize,
    vertices: Vertices,
    /// Rows of each MVoxel, channels fastest, then the first axis.
    rows: Vec<Vec<i16>>,
}

/// Vertices of an MVoxel with so many rows along each axis of a table.
fn edges(points: [usize; 3], rows: usize) -> [usize; 3] {
    match points {
        [_, 1, 1] => [rows, 1, 1],
        [_, _, 1] => {
            let high = 1 << rows.isqrt().max(1).ilog2();
            let wide = 1 << (rows / high).max(1).ilog2();
            [wide, high, 1]
        }
        _ => [(1..=40usize).rev().find(|e| e.pow(3) <= rows).unwrap_or(1); 3],
    }
}

impl MVoxelTable {
    pub(super) fn new(table: &Table, codes: &[i16], rows: usize) -> Result<Self, FieldError> {
        let points = table.points();
        let edge = edges(points, rows);
        let flat = (0..3).any(|axis| points[axis] > 1 && edge[axis] < 2);
        if flat {
            let vertices = table.vertices();
            let expected = format!("{vertices} rows or more, for a cell's vertices");
            return Err(part("mvoxel.rows", rows.to_string(), expected));
        }
        let along = |axis: usize| match points[axis] {
            1 => 1,
            points => (points - 1).div_ceil(edge[axis] - 1),
        };
        let mut made = Self {
            points,
            edge,
            counts: [0, 1, 2].map(along),
            channels: table.channels(),
            vertices: vertices(table),
            rows: vec![],
        };
        made.rows = (0..made.counts.iter().product())
            .map(|mvoxel| made.cut(mvoxel, codes))
            .collect();
        Ok(made)
    }

    fn cut(&self, mvoxel: usize, codes: &[i16]) -> Vec<i16> {
        let [wide, high, deep] = self.extent(mvoxel);
        let [x, y, z] = self.first(mvoxel);
        let mut rows = Vec::with_capacity(wide * high * deep * self.channels);
        for plane in z..z + deep {
            for line in y..y + high {
                let start = x + self.points[0] * (line + self.points[1] * plane);
                rows.extend_from_slice(&codes[start * self.channels..][..wide * self.channels]);
            }
        }
        rows
    }

    /// Cells along each axis of an MVoxel; 1 where there are none.
    fn stride(&self) -> [usize; 3] {
        self.edge.map(|edge| (edge - 1).max(1))
    }

    fn index(&self, mvoxel: usize) -> [usize; 3] {
        let [x, y, _] = self.counts;
        [mvoxel % x, mvoxel / x % y, mvoxel / (x * y)]
    }

    fn first(&self, mvoxel: usize) -> [usize; 3] {
        let (index, stride) = (self.index(mvoxel), self.stride());
        [0, 1, 2].map(|axis| index[axis] * stride[axis])
    }

    fn extent(&self, mvoxel: usize) -> [usize; 3] {
        let first = self.first(mvoxel);
        [0, 1, 2].map(|axis| self.edge[axis].min(self.points[axis] - first[axis]))
    }

    /// Vertices an entry.
    #[must_use]
    pub const fn vertices(&self) -> Vertices {
        self.vertices
    }

    /// MVoxels along each axis.
    #[must_use]
    pub const fn counts(&self) -> [usize; 3] {
        self.counts
    }

    pub(super) const fn channels(&self) -> usize {
        self.channels
    }

    /// Rows of an MVoxel, channels side by side, the first axis fastest.
    #[must_use]
    pub fn rows(&self, mvoxel: usize) -> &[i16] {
        &self.rows[mvoxel]
    }

    /// The MVoxel of a place in vertices, and the entry that gathers there.
    #[must_use]
    pub fn entry(&self, at: &Located, weight_bits: u32) -> (usize, RitEntry) {
        let (low, fraction) = cell(self.points, at.place);
        let (mvoxel, row) = self.corners(low);
        (
            mvoxel,
            entry(at.slot, self.vertices, fraction, weight_bits, row),
        )
    }

    /// The MVoxel of a place in vertices, and the last row that its entry reads.
    pub(super) fn reach(&self, place: DVec3) -> (usize, u16) {
        let (low, _) = cell(self.points, place);
        let (mvoxel, row) = self.corners(low);
        (mvoxel, row(self.vertices.count() - 1))
    }

    /// The MVoxel of a cell, and the row in it of each of the cell's corners.
    fn corners(&self, low: [usize; 3]) -> (usize, impl Fn(usize) -> u16) {
        let stride = self.stride();
        let index = [0, 1, 2].map(|axis| low[axis] / stride[axis]);
        let mvoxel = index[0] + self.counts[0] * (index[1] + self.counts[1] * index[2]);
        let [wide, high, _] = self.extent(mvoxel);
        let row = move |corner: usize| {
            let [x, y, z] = [0, 1, 2].map(|axis| low[axis] % stride[axis] + (corner >> axis & 1));
            (x + wide * (y + high * z)) as u16
        };
        (mvoxel, row)
    }

    /// How far an MVoxel is from the one of the camera, which is at `eye` in
    /// vertices.
    #[must_use]
    pub fn distance(&self, mvoxel: usize, eye: DVec3) -> u64 {
        let (index, stride) = (self.index(mvoxel), self.stride());
        let along = |axis: usize| {
            if self.points[axis] == 1 {
                return 0;
            }
            index_of(eye[axis], stride[axis]).abs_diff(index[axis] as i64)
        };
        along(0) + along(1) + along(2)
    }

    pub(super) fn gathers(&self, eye: DVec3, samples: &[Located], weight_bits: u32) -> Gathers {
        let distances: Vec<u64> = (0..self.rows.len())
            .map(|mvoxel| self.distance(mvoxel, eye))
            .collect();
        let placed = (0..)
            .zip(samples)
            .map(|(sample, at)| {
                let (mvoxel, entry) = self.entry(at, weight_bits);
                Placed {
                    distance: distances[mvoxel],
                    mvoxel: mvoxel as u32,
                    sample,
                    entry,
                }
            })
            .collect();
        visit(placed, |same| self.task(same))
    }

    /// A task that loads the rows up to the last that its entries use.
    fn task(&self, same: &[Placed]) -> GatherTask {
        let top = self.vertices.count() - 1;
        let last = same.iter().map(|e| e.entry.rows[top]).max();
        let used = (usize::from(last.unwrap_or_default()) + 1) * self.channels;
        GatherTask {
            vertices: self.vertices,
            channels: self.channels,
            rows: self.rows[same[0].mvoxel as usize][..used].to_vec(),
            entries: same.iter().map(|e| e.entry).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mvoxels_fill_the_rows_as_far_as_they_go() {
        assert_eq!(edges([9, 9, 1], 512), [32, 16, 1]);
        assert_eq!(edges([9, 9, 1], 256), [16, 16, 1]);
        assert_eq!(edges([9, 9, 1], 8), [4, 2, 1]);
        assert_eq!(edges([9, 1, 1], 512), [512, 1, 1]);
        assert_eq!(edges([9, 9, 9], 512), [8; 3]);
        assert_eq!(edges([9, 9, 9], 1 << 16), [40; 3]);
    }
}
