//! A voxel grid as a field: density and colours are stored, not computed.

use glam::DVec3;

use super::grid::Grid;
use crate::{Algorithm, Along, Field, Sampling, Table, outside};
use potamoi_march::tiling::cell;

/// Default early-termination threshold (transmittance).
pub const STOP_BELOW: f64 = 1e-3;

/// Description of the algorithm for reports.
pub static ALGORITHM: Algorithm = Algorithm {
    name: "stored voxels",
    outside: &[outside::INDEXING, outside::RIT, outside::COMPOSITING],
    full_size: None,
    preset: "paper",
    file: None,
};

/// A grid in vertex units: vertex (x, y, z) lies at (x, y, z), and lengths are in voxel edges.
pub(super) struct InVertices<'a> {
    pub(super) grid: &'a Grid,
    /// Step in voxel edges.
    pub(super) step: f64,
    /// Early-termination threshold (transmittance).
    pub(super) stop: f64,
    /// Whether linear colours depend on the viewing direction.
    pub(super) directions: bool,
}

impl InVertices<'_> {
    fn last(&self) -> DVec3 {
        DVec3::from(self.grid.points().map(|p| (p - 1) as f64))
    }
}

impl Field for InVertices<'_> {
    fn algorithm(&self) -> &'static Algorithm {
        &ALGORITHM
    }

    fn tables(&self) -> &[Table] {
        std::slice::from_ref(self.grid.table())
    }

    fn place(&self, at: DVec3, places: &mut [DVec3]) {
        places[0] = at;
    }

    fn holds(&self, _: DVec3) -> bool {
        true
    }

    fn depth(&self, features: &[f64]) -> f64 {
        features[0].max(0.0) * self.step
    }

    fn colour(&self, features: &[f64], direction: DVec3, _: &mut Vec<f64>) -> DVec3 {
        let coefficients = self.grid.layout().coefficients();
        let terms = if self.directions { coefficients } else { 1 };
        let basis = [1.0, direction.x, direction.y, direction.z];
        let channel = |c: usize| {
            let own = &features[1 + c * coefficients..][..terms];
            let sum: f64 = own.iter().zip(basis).map(|(v, b)| v * b).sum();
            sum.max(0.0)
        };
        DVec3::new(channel(0), channel(1), channel(2))
    }

    fn sampling(&self) -> Sampling {
        Sampling {
            bounds: [DVec3::ZERO, self.last()],
            step: self.step,
            range: [0.0, f64::INFINITY],
            along: Along::Axis,
            least_opacity: 0.0,
            least_weight: 0.0,
            stop: self.stop,
        }
    }
}

/// A grid in world coordinates. Samples are gathered unless no vertex of their cell has a density.
/// Cells are found from positions in the hardware's format.
pub struct StoredField<'a> {
    vertices: InVertices<'a>,
    /// For each cell, whether one of its vertices has a positive density, x fastest.
    filled: Vec<bool>,
}

/// For each cell, whether one of its vertices has a positive density.
fn filled(grid: &Grid) -> Vec<bool> {
    let [nx, ny, nz] = grid.points();
    let mut filled = vec![false; (nx - 1) * (ny - 1) * (nz - 1)];
    let vertices = grid.features().chunks_exact(grid.layout().channels());
    for (i, _) in vertices.enumerate().filter(|(_, v)| v[0] > 0.0) {
        let near = |at: usize, points: usize| at.saturating_sub(1)..=at.min(points - 2);
        for z in near(i / (nx * ny), nz) {
            for y in near(i / nx % ny, ny) {
                for x in near(i % nx, nx) {
                    filled[x + (nx - 1) * (y + (ny - 1) * z)] = true;
                }
            }
        }
    }
    filled
}

impl<'a> StoredField<'a> {
    /// A grid sampled every `step` voxel edges.
    #[must_use]
    pub fn new(grid: &'a Grid, step: f64) -> Self {
        Self {
            vertices: InVertices {
                grid,
                step,
                stop: STOP_BELOW,
                directions: true,
            },
            filled: filled(grid),
        }
    }
}

impl Field for StoredField<'_> {
    fn algorithm(&self) -> &'static Algorithm {
        &ALGORITHM
    }

    fn tables(&self) -> &[Table] {
        self.vertices.tables()
    }

    fn place(&self, at: DVec3, places: &mut [DVec3]) {
        places[0] = self.vertices.grid.to_grid(at);
    }

    fn holds(&self, at: DVec3) -> bool {
        let grid = self.vertices.grid;
        let points = grid.points();
        let ([x, y, z], _) = cell(points, grid.to_grid(at).to_array());
        self.filled[x + (points[0] - 1) * (y + (points[1] - 1) * z)]
    }

    fn depth(&self, features: &[f64]) -> f64 {
        self.vertices.depth(features)
    }

    fn colour(&self, features: &[f64], direction: DVec3, scratch: &mut Vec<f64>) -> DVec3 {
        self.vertices.colour(features, direction, scratch)
    }

    fn sampling(&self) -> Sampling {
        let grid = self.vertices.grid;
        Sampling {
            bounds: grid.bounds(),
            step: self.vertices.step * grid.voxel(),
            ..self.vertices.sampling()
        }
    }
}
