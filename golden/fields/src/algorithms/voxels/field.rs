//! A voxel grid as a field: density and colours are stored, not computed.

use std::sync::{Arc, OnceLock};

use glam::DVec3;
use potamoi_formats::config::Config;
use serde::{Serialize, Serializer};

use super::grid::Grid;
use super::ranges::Ranges;
use crate::volume::Rays;
use crate::{
    Algorithm, Along, AnyField, CoordinateFrame, Density, Directions, Field, FieldError, Local,
    QuantisedField, Sampling, Stepped, Storage, StoredDensity, Table, unverified_work,
};
use potamoi_base::camera::Camera;
use potamoi_base::sh;
use potamoi_base::sh_degrees::{self, Bands};
use potamoi_march::tiling::cell;

/// Default early-termination threshold (transmittance).
pub const STOP_BELOW: f64 = 1e-3;
/// Default step in voxel edges.
pub const STEP: f64 = 0.5;

/// Description of the algorithm for reports.
pub static ALGORITHM: Algorithm = Algorithm {
    name: "stored voxels",
    outside: &[
        unverified_work::INDEXING,
        unverified_work::RIT,
        unverified_work::COMPOSITING,
    ],
    full_size: None,
    preset: "paper",
    file: None,
};

/// A grid in vertex units: vertex (x, y, z) lies at (x, y, z), and lengths are in voxel edges.
struct InVertices<'a> {
    grid: &'a Grid,
    /// Step in voxel edges.
    step: f64,
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
        let basis = [1.0, direction.x, direction.y, direction.z];
        let channel = |c: usize| {
            let own = &features[1 + c * coefficients..][..coefficients];
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
            stop: STOP_BELOW,
        }
    }
}

/// A grid in world coordinates. Samples are gathered unless no vertex of their cell has a density.
/// Cells are found from positions in the hardware's format. Clones share the grid.
#[derive(Debug, Clone)]
pub struct StoredField {
    pub(super) grid: Arc<Grid>,
    /// Step in voxel edges.
    pub(super) step: f64,
    /// For each cell, whether one of its vertices has a positive density, x fastest.
    filled: Arc<OnceLock<Vec<bool>>>,
    /// What bounds of errors take from the grid.
    ranges: Arc<OnceLock<Ranges>>,
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

impl StoredField {
    /// A grid sampled every `step` voxel edges.
    #[must_use]
    pub fn new(grid: Grid, step: f64) -> Self {
        Self {
            grid: grid.into(),
            step,
            filled: Arc::default(),
            ranges: Arc::default(),
        }
    }

    /// The grid.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// Found once for all clones.
    pub(super) fn ranges(&self) -> &Ranges {
        self.ranges.get_or_init(|| Ranges::new(&self.grid))
    }

    fn in_vertices(&self) -> InVertices<'_> {
        InVertices {
            grid: &self.grid,
            step: self.step,
        }
    }
}

impl From<Grid> for StoredField {
    /// The grid, sampled every [`STEP`] voxel edges.
    fn from(grid: Grid) -> Self {
        Self::new(grid, STEP)
    }
}

impl From<Grid> for AnyField {
    fn from(grid: Grid) -> Self {
        Self::new(StoredField::from(grid))
    }
}

impl Serialize for StoredField {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        (&*self.grid, self.step).serialize(to)
    }
}

impl Field for StoredField {
    fn algorithm(&self) -> &'static Algorithm {
        &ALGORITHM
    }

    fn tables(&self) -> &[Table] {
        std::slice::from_ref(self.grid.table())
    }

    fn place(&self, at: DVec3, places: &mut [DVec3]) {
        places[0] = self.grid.to_grid(at);
    }

    fn holds(&self, at: DVec3) -> bool {
        let points = self.grid.points();
        let ([x, y, z], _) = cell(points, self.grid.to_grid(at).to_array());
        let filled = self.filled.get_or_init(|| filled(&self.grid));
        filled[x + (points[0] - 1) * (y + (points[1] - 1) * z)]
    }

    fn depth(&self, features: &[f64]) -> f64 {
        self.in_vertices().depth(features)
    }

    fn colour(&self, features: &[f64], direction: DVec3, scratch: &mut Vec<f64>) -> DVec3 {
        self.in_vertices().colour(features, direction, scratch)
    }

    fn sampling(&self) -> Sampling {
        Sampling {
            bounds: self.grid.bounds(),
            step: self.step * self.grid.voxel(),
            ..self.in_vertices().sampling()
        }
    }

    /// In vertex units, as in the hardware's formats.
    fn local(&self, camera: &Camera) -> Result<Option<Local<'_>>, FieldError> {
        Rays::placed(&self.grid.placement(), camera, self.step)?;
        Ok(Some(Local {
            field: Box::new(self.in_vertices()),
            frame: CoordinateFrame {
                corner: self.grid.corner(),
                edge: self.grid.voxel(),
            },
        }))
    }

    /// The density before its ReLU, which is linear between vertices.
    fn density(&self, at: DVec3, sample: &mut Density) -> f64 {
        sample.gather(self, at)[0] / self.grid.voxel()
    }

    fn coded(&self, config: &Config) -> Result<QuantisedField<'_>, FieldError> {
        let (volume, head) = self.fixed(config)?;
        Ok(QuantisedField {
            storage: Storage::Volume(Box::new(volume)),
            head: Box::new(head),
        })
    }

    fn directions(&self) -> Directions<'_> {
        let layout = self.grid.layout();
        let terms = layout.coefficients();
        let vertices = self.grid.features().chunks_exact(layout.channels());
        let holders = vertices.map(|vertex| {
            let colours = vertex[1..].chunks_exact(terms);
            let mut used = [false; sh::MAX_DEGREE + 1];
            for colour in colours {
                let own = sh_degrees::used(colour.iter().map(std::slice::from_ref));
                used.iter_mut().zip(own).for_each(|(to, own)| *to |= own);
            }
            used
        });
        Directions::Harmonics {
            bands: Bands::of(terms.isqrt() - 1, holders),
            holders: "vertices",
        }
    }

    fn stepped(&self) -> Option<&dyn Stepped> {
        Some(self)
    }

    fn stored(&self) -> Option<&dyn StoredDensity> {
        Some(self)
    }
}

impl Stepped for StoredField {
    fn with_step(&self, step: f64) -> AnyField {
        AnyField::new(Self {
            step,
            ..self.clone()
        })
    }
}
