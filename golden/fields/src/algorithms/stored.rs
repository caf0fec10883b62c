//! Density and colours that are stored as they are: the grids of the built-in
//! scenes as a field.

use glam::DVec3;

use crate::voxels::{Grid, STOP_BELOW};
use crate::{Algorithm, Along, Field, FieldError, Sampling, Table, outside};
use potamoi_march::tiling::cell;

/// A grid, one table.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredField {
    tables: [Table; 1],
    corner: DVec3,
    voxel: f64,
    coefficients: usize,
    /// In voxel edges.
    step: f64,
    /// Whether a vertex of each cell has a positive density, x fastest.
    filled: Vec<bool>,
}

/// Cells with a vertex of positive density.
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

impl StoredField {
    /// A grid that is sampled every `step` voxel edges.
    ///
    /// # Errors
    /// A grid that is no table.
    pub fn new(grid: &Grid, step: f64) -> Result<Self, FieldError> {
        let layout = grid.layout();
        let table = Table::new(grid.points(), layout.channels(), grid.features().to_vec())?;
        Ok(Self {
            tables: [table],
            corner: grid.corner(),
            voxel: grid.voxel(),
            coefficients: layout.coefficients(),
            step,
            filled: filled(grid),
        })
    }
}

/// As reports tell it.
pub static ALGORITHM: Algorithm = Algorithm {
    name: "stored voxels",
    outside: &[outside::INDEXING, outside::RIT, outside::COMPOSITING],
    full_size: None,
    preset: "paper",
    file: None,
};

impl Field for StoredField {
    fn algorithm(&self) -> &'static Algorithm {
        &ALGORITHM
    }

    fn tables(&self) -> &[Table] {
        &self.tables
    }

    fn place(&self, at: DVec3, places: &mut [DVec3]) {
        places[0] = (at - self.corner) / self.voxel;
    }

    fn holds(&self, at: DVec3) -> bool {
        let points = self.tables[0].points();
        let ([x, y, z], _) = cell(points, ((at - self.corner) / self.voxel).to_array());
        self.filled[x + (points[0] - 1) * (y + (points[1] - 1) * z)]
    }

    fn depth(&self, features: &[f64]) -> f64 {
        features[0].max(0.0) * self.step
    }

    fn colour(&self, features: &[f64], direction: DVec3, _: &mut Vec<f64>) -> DVec3 {
        let basis = [1.0, direction.x, direction.y, direction.z];
        let channel = |c: usize| {
            let terms = &features[1 + c * self.coefficients..][..self.coefficients];
            let sum: f64 = terms.iter().zip(basis).map(|(v, b)| v * b).sum();
            sum.max(0.0)
        };
        DVec3::new(channel(0), channel(1), channel(2))
    }

    fn sampling(&self) -> Sampling {
        let last = DVec3::from(self.tables[0].points().map(|p| (p - 1) as f64));
        Sampling {
            bounds: [self.corner, self.corner + last * self.voxel],
            step: self.step * self.voxel,
            range: [0.0, f64::INFINITY],
            along: Along::Axis,
            least_opacity: 0.0,
            least_weight: 0.0,
            stop: STOP_BELOW,
        }
    }
}
