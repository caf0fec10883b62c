//! MVoxels: what one filling of the MVoxel feature table holds (paper, Sec.
//! "Memory Optimizations" and "Hardware Support").
//!
//! An MVoxel of `e` vertices an edge holds `e - 1` whole cells an edge, and
//! MVoxels follow one another at that stride: the vertices of a shared face
//! (the *halo*) are stored in both, so that every sample has one entry. With 8
//! vertices an edge that takes (8/7)^3 = 1.49 times the bytes in bulk.
//!
//! Where the halo is *split* nothing is stored twice: MVoxels follow one another
//! at a stride of `e`, and a sample whose vertices lie in several has an entry in
//! each. Their unrounded sums are added up and rounded once, so that the picture
//! is the same bit for bit.
//!
//! A sample belongs to the cell whose lower faces it is on or above; on the
//! volume's upper faces, to the last cell. So it has one owner everywhere.

mod halo;

use glam::DVec3;
use potamoi_formats::config::Config;

use super::error::VoxelError;
use super::formats::{FRACTION_BITS, Formats, code};
use super::grid::Grid;
use crate::streams::RitReads;
use crate::units::gather::Reducer;

pub use halo::Halo;

/// Vertices an edge of the largest cube that so many rows hold.
pub(crate) fn cube_edge(rows: u32) -> Option<usize> {
    // A row number has 16 bits.
    (2..=40).take_while(|e| e * e * e <= rows as usize).last()
}

/// A grid's features as codes, cut into MVoxels.
#[derive(Debug, Clone, PartialEq)]
pub struct MVoxels {
    edge: usize,
    halo: Halo,
    points: [usize; 3],
    counts: [usize; 3],
    channels: usize,
    reducer: Reducer,
    rit_reads: RitReads,
    /// Of codes that are a grid's.
    formats: Option<Formats>,
    mask: Option<Mask>,
    /// Rows of each MVoxel, x fastest.
    rows: Vec<Vec<i16>>,
    /// A bit a cell: whether a vertex of it can give opacity.
    cells: Vec<u64>,
    occupied: Vec<bool>,
}

/// Where a sample is: its owner, the cell in it, and the place in the cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Number of the MVoxel, x fastest.
    pub mvoxel: usize,
    /// Lowest vertex of the cell, from the MVoxel's first vertex.
    pub local: [usize; 3],
    /// U1.12 fractions of the way through the cell; 1 only on the volume's
    /// upper faces.
    pub fraction: [u16; 3],
}

/// A grid of its own that says where anything may be.
#[derive(Debug, Clone, PartialEq)]
pub struct Mask {
    /// Vertices along x, y, z.
    pub points: [usize; 3],
    /// One a vertex, x fastest.
    pub filled: Vec<bool>,
    /// From a place in vertices of the field to one in vertices of the mask.
    pub scale: DVec3,
    /// Added after scaling.
    pub shift: DVec3,
}

impl Mask {
    /// Whether the nearest vertex is filled; outside, nothing is.
    #[must_use]
    pub fn holds(&self, at: DVec3) -> bool {
        let near = (at * self.scale + self.shift).round();
        let last = DVec3::from(self.points.map(|p| p as f64 - 1.0));
        if !(near.cmpge(DVec3::ZERO).all() && near.cmple(last).all()) {
            return false;
        }
        let [x, y, z] = near.to_array().map(|v| v as usize);
        let index = x + self.points[0] * (y + self.points[1] * z);
        self.filled.get(index).copied().unwrap_or_default()
    }
}

impl MVoxels {
    /// Rounds a grid's features to codes and cuts it into the largest cubic
    /// MVoxels that the configuration's rows hold.
    ///
    /// # Errors
    /// As [`Formats::new`], or rows for less than 2 x 2 x 2 vertices.
    pub fn new(grid: &Grid, config: &Config) -> Result<Self, VoxelError> {
        let formats = Formats::new(grid, config)?;
        let channels = grid.layout().channels();
        let codes = grid.features().iter().enumerate();
        let codes = codes.map(|(i, v)| match i % channels {
            0 => code(formats.density, *v),
            _ => code(formats.colour, *v),
        });
        let codes: Vec<i16> = codes.collect();
        let mut made = Self::of_codes(grid.points(), channels, &codes, config, |v| v[0] > 0)?;
        made.formats = Some(formats);
        Ok(made)
    }

    /// Cuts `codes`, `channels` a vertex and x fastest, into the largest cubic
    /// MVoxels that the configuration's rows hold. `counts` says whether a
    /// vertex can give opacity.
    ///
    /// # Errors
    /// Rows for less than 2 x 2 x 2 vertices, or codes that are not one a
    /// vertex and channel.
    pub fn of_codes(
        points: [usize; 3],
        channels: usize,
        codes: &[i16],
        config: &Config,
        counts: impl Fn(&[i16]) -> bool,
    ) -> Result<Self, VoxelError> {
        let expected = points.iter().product::<usize>() * channels;
        if codes.len() != expected || channels == 0 || points.iter().any(|p| *p < 2) {
            return Err(VoxelError::Grid {
                field: "codes",
                value: format!("{} of {points:?} x {channels}", codes.len()),
                expected: "one a vertex and channel of 2 x 2 x 2 vertices or more".to_owned(),
            });
        }
        let Some(edge) = cube_edge(config.mvoxel.rows) else {
            return Err(VoxelError::Config {
                field: "mvoxel.rows",
                value: config.mvoxel.rows.to_string(),
                expected: "8 rows or more, for 2 x 2 x 2 vertices".to_owned(),
            });
        };
        let mut mvoxels = Self {
            edge,
            halo: Halo::Shared,
            points,
            counts: Self::counts_of(points, edge, Halo::Shared),
            channels,
            reducer: Reducer::new(config),
            rit_reads: RitReads::of(config),
            formats: None,
            mask: None,
            rows: Vec::new(),
            cells: Vec::new(),
            occupied: Vec::new(),
        };
        mvoxels.rows = (0..mvoxels.counts.iter().product())
            .map(|m| mvoxels.cut(m, codes))
            .collect();
        mvoxels.find_occupied(codes, counts);
        Ok(mvoxels)
    }

    /// The same, with a mask outside which no sample is.
    #[must_use]
    pub fn masked(mut self, mask: Mask) -> Self {
        self.mask = Some(mask);
        self
    }

    fn counts_of(points: [usize; 3], edge: usize, halo: Halo) -> [usize; 3] {
        points.map(|p| match halo {
            Halo::Shared => (p - 1).div_ceil(edge - 1),
            Halo::Split => p.div_ceil(edge),
        })
    }

    /// The row of a vertex of an MVoxel.
    fn row(&self, mvoxel: usize, [x, y, z]: [usize; 3]) -> usize {
        let [wide, high, _] = self.extent(mvoxel);
        x + wide * (y + high * z)
    }

    fn cut(&self, mvoxel: usize, codes: &[i16]) -> Vec<i16> {
        let first = self.first(mvoxel);
        let [wide, high, deep] = self.extent(mvoxel);
        let mut rows = Vec::with_capacity(wide * high * deep * self.channels);
        for z in first[2]..first[2] + deep {
            for y in first[1]..first[1] + high {
                let start = first[0] + self.points[0] * (y + self.points[1] * z);
                rows.extend_from_slice(&codes[start * self.channels..][..wide * self.channels]);
            }
        }
        rows
    }

    fn find_occupied(&mut self, codes: &[i16], counts: impl Fn(&[i16]) -> bool) {
        let [nx, ny, _] = self.points;
        let cells = self.points.map(|p| p - 1);
        self.cells = vec![0; cells.iter().product::<usize>().div_ceil(64)];
        self.occupied = vec![false; self.rows.len()];
        for (vertex, channels) in codes.chunks_exact(self.channels).enumerate() {
            if !counts(channels) {
                continue;
            }
            let at = [vertex % nx, vertex / nx % ny, vertex / (nx * ny)];
            for corner in 0..8 {
                let mut cell = [0; 3];
                let inside = (0..3).all(|axis| {
                    let c = at[axis].wrapping_sub(corner >> axis & 1);
                    cell[axis] = c;
                    c < cells[axis]
                });
                if inside {
                    let index = self.cell_index(cell);
                    self.cells[index / 64] |= 1 << (index % 64);
                    let owner = self.number(cell.map(|c| c / self.stride()));
                    self.occupied[owner] = true;
                }
            }
        }
    }

    fn cell_index(&self, [x, y, z]: [usize; 3]) -> usize {
        x + (self.points[0] - 1) * (y + (self.points[1] - 1) * z)
    }

    fn number(&self, [x, y, z]: [usize; 3]) -> usize {
        x + self.counts[0] * (y + self.counts[1] * z)
    }

    /// From MVoxel to MVoxel in vertices: cells an edge whose vertices one MVoxel
    /// holds, or vertices an edge where the halo is split.
    #[must_use]
    pub fn stride(&self) -> usize {
        match self.halo {
            Halo::Shared => self.edge - 1,
            Halo::Split => self.edge,
        }
    }

    /// How MVoxels share vertices.
    #[must_use]
    pub fn halo(&self) -> Halo {
        self.halo
    }

    /// The arithmetic of sums.
    #[must_use]
    pub fn reducer(&self) -> &Reducer {
        &self.reducer
    }

    /// How often the ray index table is read.
    #[must_use]
    pub fn rit_reads(&self) -> RitReads {
        self.rit_reads
    }

    /// MVoxels along x, y, z.
    #[must_use]
    pub fn counts(&self) -> [usize; 3] {
        self.counts
    }

    /// Vertices of the grid along x, y, z.
    #[must_use]
    pub fn points(&self) -> [usize; 3] {
        self.points
    }

    /// Channels `C` of a vertex.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// The formats of the codes, where they are a grid's.
    #[must_use]
    pub fn formats(&self) -> Option<&Formats> {
        self.formats.as_ref()
    }

    /// Fraction bits of weights.
    #[must_use]
    pub fn weight_bits(&self) -> u32 {
        self.reducer.weight_bits()
    }

    /// Whether anything may be at a place in vertices: the mask's word, or yes.
    #[must_use]
    pub fn holds(&self, at: DVec3) -> bool {
        self.mask.as_ref().is_none_or(|mask| mask.holds(at))
    }

    /// Index of an MVoxel along x, y, z.
    #[must_use]
    pub fn index(&self, mvoxel: usize) -> [usize; 3] {
        let [x, y, _] = self.counts;
        [mvoxel % x, mvoxel / x % y, mvoxel / (x * y)]
    }

    /// The grid's vertex that is an MVoxel's first.
    #[must_use]
    pub fn first(&self, mvoxel: usize) -> [usize; 3] {
        self.index(mvoxel).map(|i| i * self.stride())
    }

    /// Vertices along x, y, z of an MVoxel: fewer than an edge at the volume's
    /// upper faces.
    #[must_use]
    pub fn extent(&self, mvoxel: usize) -> [usize; 3] {
        let first = self.first(mvoxel);
        let mut extent = [0; 3];
        for axis in 0..3 {
            extent[axis] = self.edge.min(self.points[axis] - first[axis]);
        }
        extent
    }

    /// Rows of an MVoxel, channel codes side by side, x fastest.
    #[must_use]
    pub fn rows(&self, mvoxel: usize) -> &[i16] {
        &self.rows[mvoxel]
    }

    /// Whether a sample in this MVoxel can have an opacity above 0: a vertex of
    /// one of its cells can give it.
    #[must_use]
    pub fn is_occupied(&self, mvoxel: usize) -> bool {
        self.occupied[mvoxel]
    }

    /// The same of the cell of a sample.
    #[must_use]
    pub fn is_cell_occupied(&self, place: &Place) -> bool {
        let first = self.first(place.mvoxel);
        let mut cell = [0; 3];
        for axis in 0..3 {
            cell[axis] = first[axis] + place.local[axis];
        }
        let index = self.cell_index(cell);
        self.cells[index / 64] >> (index % 64) & 1 == 1
    }

    /// Vertices stored over vertices of the grid: what the halo costs.
    #[must_use]
    pub fn duplication(&self) -> f64 {
        let stored: usize = self.rows.iter().map(|r| r.len() / self.channels).sum();
        stored as f64 / self.points.iter().product::<usize>() as f64
    }

    /// The owner of a position in vertex units, held to the volume and rounded
    /// to 12 fraction bits.
    #[must_use]
    pub fn locate(&self, at: [f64; 3]) -> Place {
        let mut index = [0; 3];
        let mut local = [0; 3];
        let mut fraction = [0; 3];
        for axis in 0..3 {
            let cells = self.points[axis] - 1;
            let code = (position_code(at[axis]).max(0) as u64).min((cells as u64) << FRACTION_BITS);
            let cell = ((code >> FRACTION_BITS) as usize).min(cells - 1);
            index[axis] = cell / self.stride();
            local[axis] = cell % self.stride();
            fraction[axis] = (code - ((cell as u64) << FRACTION_BITS)) as u16;
        }
        Place {
            mvoxel: self.number(index),
            local,
            fraction,
        }
    }

    /// Rows of the eight corners of a place's cell, all of which its owner holds;
    /// bit 0 of the corner's index is x, bit 1 y, bit 2 z.
    #[must_use]
    pub fn corner_rows(&self, place: &Place) -> [u16; 8] {
        let mut rows = [0; 8];
        for (corner, row) in rows.iter_mut().enumerate() {
            let bit = |axis: usize| corner >> axis & 1;
            let at = [0, 1, 2].map(|axis| place.local[axis] + bit(axis));
            *row = self.row(place.mvoxel, at) as u16;
        }
        rows
    }

    /// For every MVoxel, how far it is from the camera's: the Manhattan
    /// distance of their indices, less the least of all. A ray that leaves the
    /// camera, at `camera` in vertex units, meets the owners of its samples at
    /// strictly increasing distances, since none of its indices ever turns back.
    #[must_use]
    pub fn distances(&self, camera: [f64; 3]) -> Vec<u32> {
        let own = camera.map(|v| {
            let index = position_code(v).div_euclid((self.stride() as i64) << FRACTION_BITS);
            // Far enough, and no sum of three overflows.
            index.clamp(-(1 << 50), 1 << 50)
        });
        let far: Vec<u64> = (0..self.rows.len())
            .map(|m| {
                let index = self.index(m);
                let along = |axis: usize| own[axis].abs_diff(index[axis] as i64);
                along(0) + along(1) + along(2)
            })
            .collect();
        let least = far.iter().min().copied().unwrap_or_default();
        far.iter().map(|d| (d - least) as u32).collect()
    }
}

/// A coordinate with 12 fraction bits, to nearest; monotone, and saturating.
pub(crate) fn position_code(v: f64) -> i64 {
    (v * f64::from(1u32 << FRACTION_BITS)).round() as i64
}
