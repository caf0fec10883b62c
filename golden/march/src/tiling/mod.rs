//! Lines, planes and volumes of vertices cut into MVoxels, each of which fills the MVoxel feature
//! table once (paper, Sec. "Memory Optimizations" and "Hardware Support").
//!
//! An MVoxel of `e` vertices an edge holds `e - 1` whole cells an edge, and MVoxels follow one
//! another at that stride. The vertices of a shared face (the *halo*) are stored in both, so that
//! every sample has one entry. With 8 vertices an edge a large volume takes (8/7)^3 = 1.49 times
//! the bytes.
//!
//! With a *split* halo nothing is stored twice: MVoxels follow one another at a stride of `e`, and
//! a sample whose vertices lie in several MVoxels has an entry in each. Their unrounded sums are
//! added and rounded once, so that the picture is the same bit for bit.
//!
//! A sample belongs to the cell whose lower faces it is on or above, or to the last cell on the
//! upper faces of the volume. So every sample has exactly one owner.

#[cfg(test)]
mod tests;
mod visit_order;

use potamoi_formats::config::MvoxelConfig;
use schemars::JsonSchema;
use serde::Serialize;

use potamoi_reference::weights::FRACTION_BITS;

pub use visit_order::position_code;

/// Storage of the vertices that neighbouring MVoxels share.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Halo {
    /// Stored in both MVoxels.
    #[default]
    Shared,
    /// Stored in one MVoxel.
    Split,
}

/// The location of a sample: owner, cell and position within the cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleLocation {
    /// Number of the owning MVoxel, x fastest.
    pub mvoxel: usize,
    /// Lowest vertex of the cell, relative to the MVoxel's first vertex.
    pub local: [usize; 3],
    /// U1.12 position within the cell; 1 only on the upper faces of the volume.
    pub fraction: [u16; 3],
}

/// An MVoxel that holds vertices of a sample's cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Holder {
    /// Number of the MVoxel, x fastest.
    pub mvoxel: usize,
    /// The axes, by bit, along which it follows the owner.
    pub behind: usize,
}

/// A division of vertices into MVoxels. Planes and lines have one vertex along their last axes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Tiling {
    points: [usize; 3],
    edge: [usize; 3],
    halo: Halo,
    /// Stride between MVoxels in vertices: an edge less one, or a whole edge with a split halo.
    stride: [usize; 3],
    counts: [usize; 3],
}

/// Vertices along each axis of an MVoxel with this many rows, as in hardware:
/// [`MvoxelConfig::edges`]. `None` if the rows cannot hold the vertices of a cell.
pub fn edges(points: [usize; 3], rows: u32) -> Option<[usize; 3]> {
    let axes = match points {
        [_, 1, 1] => 1,
        [_, _, 1] => 2,
        _ => 3,
    };
    let edge = MvoxelConfig { rows }.edges(axes)?;
    (0..3)
        .all(|a| points[a] == 1 || edge[a] > 1)
        .then_some(edge)
}

/// The lowest vertex of the cell at a position in vertices, clamped to `points` vertices, and the
/// U1.12 position within the cell. That is 1 only on the upper faces.
#[inline]
pub fn cell(points: [usize; 3], place: [f64; 3]) -> ([usize; 3], [u16; 3]) {
    let (mut low, mut fraction) = ([0; 3], [0; 3]);
    for axis in 0..3 {
        let cells = points[axis] - 1;
        let code = position_code(place[axis]).max(0) as u64;
        let code = code.min((cells as u64) << FRACTION_BITS);
        low[axis] = ((code >> FRACTION_BITS) as usize).min(cells.saturating_sub(1));
        fraction[axis] = (code - ((low[axis] as u64) << FRACTION_BITS)) as u16;
    }
    (low, fraction)
}

impl Tiling {
    /// MVoxels of at most `edge` vertices along each axis, at least 2 along axes of several
    /// vertices.
    pub fn new(points: [usize; 3], edge: [usize; 3], halo: Halo) -> Self {
        let stride = match halo {
            Halo::Shared => edge.map(|edge| (edge - 1).max(1)),
            Halo::Split => edge,
        };
        let along = |axis: usize| match (points[axis], halo) {
            (1, _) => 1,
            (points, Halo::Shared) => (points - 1).div_ceil(stride[axis]),
            (points, Halo::Split) => points.div_ceil(stride[axis]),
        };
        Self {
            points,
            edge,
            halo,
            stride,
            counts: [0, 1, 2].map(along),
        }
    }

    /// The same division with another halo.
    pub fn with_halo(&self, halo: Halo) -> Self {
        Self::new(self.points, self.edge, halo)
    }

    /// The kind of halo.
    #[must_use]
    pub const fn halo(&self) -> Halo {
        self.halo
    }

    /// Vertices along each axis.
    #[must_use]
    pub const fn points(&self) -> [usize; 3] {
        self.points
    }

    /// MVoxels along each axis.
    #[cfg(test)]
    pub(crate) const fn counts(&self) -> [usize; 3] {
        self.counts
    }

    /// Total number of MVoxels.
    pub fn count(&self) -> usize {
        self.counts.iter().product()
    }

    #[inline]
    /// Stride between MVoxels in vertices, along each axis.
    #[must_use]
    pub const fn stride(&self) -> [usize; 3] {
        self.stride
    }

    #[inline]
    pub(crate) const fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.counts[0] * (y + self.counts[1] * z)
    }

    /// Index of an MVoxel along each axis.
    #[inline]
    #[must_use]
    pub const fn index(&self, mvoxel: usize) -> [usize; 3] {
        let [x, y, _] = self.counts;
        [mvoxel % x, mvoxel / x % y, mvoxel / (x * y)]
    }

    /// The first vertex of an MVoxel.
    #[inline]
    pub fn first(&self, mvoxel: usize) -> [usize; 3] {
        let index = self.index(mvoxel);
        [0, 1, 2].map(|axis| index[axis] * self.stride[axis])
    }

    /// Vertices along each axis of an MVoxel; fewer than an edge at the upper faces of the volume.
    #[inline]
    pub fn extent(&self, mvoxel: usize) -> [usize; 3] {
        let first = self.first(mvoxel);
        [0, 1, 2].map(|axis| self.edge[axis].min(self.points[axis] - first[axis]))
    }

    /// Rows of an MVoxel, from `codes` with `channels` a vertex and the first axis fastest.
    pub fn cut(&self, mvoxel: usize, codes: &[i16], channels: usize) -> Vec<i16> {
        let [wide, high, deep] = self.extent(mvoxel);
        let [x, y, z] = self.first(mvoxel);
        let mut rows = Vec::with_capacity(wide * high * deep * channels);
        for plane in z..z + deep {
            for line in y..y + high {
                let start = x + self.points[0] * (line + self.points[1] * plane);
                rows.extend_from_slice(&codes[start * channels..][..wide * channels]);
            }
        }
        rows
    }

    /// The MVoxel that owns the cell with this lowest vertex, and the vertex relative to the
    /// MVoxel's first.
    #[inline]
    pub fn owner(&self, low: [usize; 3]) -> (usize, [usize; 3]) {
        let number = self.number([0, 1, 2].map(|axis| low[axis] / self.stride[axis]));
        (number, [0, 1, 2].map(|axis| low[axis] % self.stride[axis]))
    }

    /// The sample location of a position in vertices, clamped to the volume and rounded to 12
    /// fraction bits.
    #[inline]
    pub fn locate(&self, at: [f64; 3]) -> SampleLocation {
        let (low, fraction) = cell(self.points, at);
        self.place(low, fraction)
    }

    /// The sample location of a position within a cell.
    #[inline]
    pub fn place(&self, low: [usize; 3], fraction: [u16; 3]) -> SampleLocation {
        let (mvoxel, local) = self.owner(low);
        SampleLocation {
            mvoxel,
            local,
            fraction,
        }
    }

    /// Rows of the eight corners of a cell, all of which its owner must hold. Bit 0 of the
    /// corner's index is x, bit 1 y, bit 2 z. Only corners along axes of several vertices are
    /// meaningful.
    #[inline]
    pub fn corner_rows(&self, place: &SampleLocation) -> [u16; 8] {
        let [wide, high, _] = self.extent(place.mvoxel);
        let mut rows = [0; 8];
        for (corner, row) in rows.iter_mut().enumerate() {
            let [x, y, z] = [0, 1, 2].map(|axis| place.local[axis] + (corner >> axis & 1));
            *row = (x + wide * (y + high * z)) as u16;
        }
        rows
    }

    /// The axes, by bit, along which the far vertices of a cell lie in the next MVoxel; none with
    /// a shared halo.
    #[inline]
    pub fn straddles(&self, place: &SampleLocation) -> usize {
        if self.halo == Halo::Shared {
            return 0;
        }
        let over =
            |axis: &usize| self.points[*axis] > 1 && place.local[*axis] + 1 == self.edge[*axis];
        (0..3).filter(over).fold(0, |bits, axis| bits | 1 << axis)
    }

    /// The MVoxels that hold vertices of a cell, the owner first.
    #[inline]
    pub fn holders(&self, place: &SampleLocation) -> impl Iterator<Item = Holder> + use<> {
        let across = self.straddles(place);
        let owner = place.mvoxel;
        let [x, y, _] = self.counts;
        let ahead = [1, x, x * y];
        let all = (0..8usize).filter(move |bits| bits & !across == 0);
        all.map(move |behind| {
            let next = (0..3).filter(|axis| behind >> axis & 1 == 1);
            Holder {
                mvoxel: owner + next.map(|axis| ahead[axis]).sum::<usize>(),
                behind,
            }
        })
    }

    /// Rows of the corners of a cell in one of its holders, and which corners it holds, by bit.
    /// The others have row 0.
    pub fn part_rows(&self, place: &SampleLocation, holder: Holder) -> ([u16; 8], u8) {
        let across = self.straddles(place);
        let [wide, high, _] = self.extent(holder.mvoxel);
        let (mut rows, mut held) = ([0; 8], 0);
        for (corner, row) in rows.iter_mut().enumerate() {
            if corner & across != holder.behind {
                continue;
            }
            held |= 1 << corner;
            let at = |axis: usize| match (across >> axis & 1, corner >> axis & 1) {
                (1, 1) => 0,
                (_, bit) => place.local[axis] + bit,
            };
            *row = (at(0) + wide * (at(1) + high * at(2))) as u16;
        }
        (rows, held)
    }

    /// The last row used by the corners of a cell in one of its holders.
    pub fn last_row(&self, place: &SampleLocation, holder: Holder) -> u16 {
        let across = self.straddles(place);
        let [wide, high, _] = self.extent(holder.mvoxel);
        let at = |axis: usize| match (across >> axis & 1, holder.behind >> axis & 1) {
            (1, 0) => place.local[axis],
            (1, _) => 0,
            _ => place.local[axis] + usize::from(self.points[axis] > 1),
        };
        (at(0) + wide * (at(1) + high * at(2))) as u16
    }
}
