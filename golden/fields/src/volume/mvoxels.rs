//! Quantised features in MVoxels ([`potamoi_march::tiling`]), with an occupancy bit for each cell.

use glam::DVec3;
use potamoi_formats::config::{Config, Sums};
use potamoi_formats::rit::Vertices;

use super::mask::Mask;
use crate::gather_plan::{MVoxelTable, Shape};
use potamoi_march::MarchError;
use potamoi_march::streams::UnitStreams;
use potamoi_march::tiling::{Halo, SampleLocation, Tiling, edges};
use potamoi_reference::gathering_unit::Reducer;

/// A volume of quantised features, cut into MVoxels.
#[derive(Debug, Clone, PartialEq)]
pub struct MVoxels {
    table: MVoxelTable,
    unit_streams: UnitStreams,
    mask: Option<Mask>,
    /// One bit a cell: whether any of its vertices can yield opacity.
    cells: Vec<u64>,
}

impl MVoxels {
    /// Cuts `codes`, `channels` a vertex and x fastest, into the largest cubic MVoxels that the
    /// configuration's rows hold. `counts` returns whether a vertex can yield opacity.
    ///
    /// # Errors
    /// There are rows for less than 2 x 2 x 2 vertices, or the number of codes is not that of
    /// vertices times channels.
    pub(crate) fn of_codes(
        points: [usize; 3],
        channels: usize,
        codes: &[i16],
        config: &Config,
        counts: impl Fn(&[i16]) -> bool,
    ) -> Result<Self, MarchError> {
        let expected = points.iter().product::<usize>() * channels;
        if codes.len() != expected || channels == 0 || points.iter().any(|p| *p < 2) {
            return Err(MarchError::Grid {
                field: "codes",
                value: format!("{} of {points:?} x {channels}", codes.len()),
                expected: "one a vertex and channel of 2 x 2 x 2 vertices or more".to_owned(),
            });
        }
        let Some(edge) = edges(points, config.mvoxel.rows) else {
            return Err(MarchError::Config {
                field: "mvoxel.rows",
                value: config.mvoxel.rows.to_string(),
                expected: "8 rows or more, for 2 x 2 x 2 vertices".to_owned(),
            });
        };
        let tiling = Tiling::new(points, edge, Halo::Shared);
        let shape = Shape {
            channels,
            vertices: Vertices::Eight,
            reducer: Reducer::new(config),
            exact_sums: config.gu.sums == Sums::Exact,
        };
        let mut mvoxels = Self {
            table: MVoxelTable::cut(tiling, shape, codes),
            unit_streams: UnitStreams::of(config),
            mask: None,
            cells: Vec::new(),
        };
        mvoxels.find_occupied(codes, counts);
        Ok(mvoxels)
    }

    /// The same vertices with another halo.
    #[must_use]
    pub fn with_halo(&self, halo: Halo) -> Self {
        let table = &self.table;
        Self {
            table: MVoxelTable::cut(
                table.tiling().with_halo(halo),
                *table.shape(),
                &table.codes(),
            ),
            mask: self.mask.clone(),
            cells: self.cells.clone(),
            ..*self
        }
    }

    /// Adds a mask. Samples outside it are skipped.
    #[must_use]
    pub fn masked(mut self, mask: Mask) -> Self {
        self.mask = Some(mask);
        self
    }

    fn find_occupied(&mut self, codes: &[i16], counts: impl Fn(&[i16]) -> bool) {
        let [nx, ny, _] = self.points();
        let cells = self.points().map(|p| p - 1);
        self.cells = vec![0; cells.iter().product::<usize>().div_ceil(64)];
        for (vertex, channels) in codes.chunks_exact(self.channels()).enumerate() {
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
                }
            }
        }
    }

    fn cell_index(&self, [x, y, z]: [usize; 3]) -> usize {
        let [wide, high, _] = self.points();
        x + (wide - 1) * (y + (high - 1) * z)
    }

    /// The division into MVoxels.
    pub(crate) fn tiling(&self) -> &Tiling {
        self.table.tiling()
    }

    /// Rows and entries.
    pub(crate) fn shape(&self) -> &Shape {
        self.table.shape()
    }

    /// The kind of halo.
    #[must_use]
    pub fn halo(&self) -> Halo {
        self.tiling().halo()
    }

    /// Sizes and passes of the gathering unit's streams.
    #[must_use]
    pub fn unit_streams(&self) -> UnitStreams {
        self.unit_streams
    }

    /// Number of vertices along x, y, z.
    #[must_use]
    pub fn points(&self) -> [usize; 3] {
        self.tiling().points()
    }

    /// Number of channels `C` of a vertex.
    #[must_use]
    pub fn channels(&self) -> usize {
        self.shape().channels
    }

    /// Whether the field may be non-empty at a position in vertices: as the mask states, or `true`
    /// without one.
    #[must_use]
    pub fn holds(&self, at: DVec3) -> bool {
        self.mask.as_ref().is_none_or(|mask| mask.holds(at))
    }

    /// Rows of an MVoxel, channels side by side, x fastest.
    #[must_use]
    pub fn rows(&self, mvoxel: usize) -> &[i16] {
        self.table.rows(mvoxel)
    }

    /// Whether the cell of a sample is occupied.
    #[must_use]
    pub(crate) fn is_cell_occupied(&self, place: &SampleLocation) -> bool {
        let first = self.tiling().first(place.mvoxel);
        let index = self.cell_index([0, 1, 2].map(|axis| first[axis] + place.local[axis]));
        self.cells[index / 64] >> (index % 64) & 1 == 1
    }

    /// Number of empty cells, and of all cells.
    #[must_use]
    pub fn void_cells(&self) -> [u64; 2] {
        let all: usize = self.points().iter().map(|p| p - 1).product();
        let occupied: u64 = self.cells.iter().map(|w| u64::from(w.count_ones())).sum();
        [all as u64 - occupied, all as u64]
    }

    /// Ratio of stored vertices to vertices of the grid: the cost of the halo.
    #[must_use]
    pub fn duplication(&self) -> f64 {
        let all = 0..self.tiling().count();
        let stored: usize = all.map(|m| self.rows(m).len() / self.channels()).sum();
        stored as f64 / self.points().iter().product::<usize>() as f64
    }

    /// Distance of every MVoxel from that of the camera, which is at `camera` in vertex units,
    /// less the smallest distance.
    #[must_use]
    pub fn distances(&self, camera: [f64; 3]) -> Vec<u32> {
        let seen = self.tiling().distances_from(camera);
        let all = 0..self.tiling().count();
        let far: Vec<u64> = all.map(|m| seen.distance(self.tiling().index(m))).collect();
        let least = far.iter().min().copied().unwrap_or_default();
        far.iter().map(|d| (d - least) as u32).collect()
    }
}
