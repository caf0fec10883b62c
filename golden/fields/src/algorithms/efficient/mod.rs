//! EfficientNeRF (Hu, Liu, Chen, Shen, Jia, CVPR 2022), rendering only: a dense coarse grid marks
//! empty cells, and a tree gives each other cell a cube of 3 x 3 x 3 fine cells. A fine cell holds
//! a density before its softplus, and spherical-harmonics coefficients of degree 2 of three
//! colours before their sigmoid. Nothing is interpolated.
//!
//! The geometry is that of the authors' code (a coarse grid of 384^3, here of any size). Samples
//! lie half a fine cell apart, in coarse cells that have a node. The models serve the paper's
//! characterisation and verification; no claim is made about their picture quality.

mod bound;
mod fixed;

use glam::{DVec3, dvec3};
use potamoi_formats::config::Config;
use rayon::prelude::*;

use crate::{
    Algorithm, Along, Bounds, Directions, Field, FieldError, Nodes, QuantisedField, Sampling, Size,
    Table, softplus, unverified_work,
};
use potamoi_base::camera::Camera;
use potamoi_base::sh;
use potamoi_base::sh_degrees::{self, Bands};
use potamoi_reference::bounds::VectorBounds;

/// Fine cells an edge of a coarse cell.
pub const FINE: usize = 3;
/// Spherical-harmonics coefficients a colour: degree 2.
pub const COEFFICIENTS: usize = 9;
/// Channels of a fine cell: the density, then the coefficients of red, green and blue.
pub const CHANNELS: usize = 1 + 3 * COEFFICIENTS;
/// The density of empty fine cells, before its softplus.
pub(crate) const EMPTY: f32 = -20.0;
/// Step in fine cells.
const STEP: f64 = 0.5;
/// Weight threshold of colours.
const LEAST_WEIGHT: f64 = 1e-4;
/// Early-termination threshold (transmittance).
const STOP: f64 = 1e-3;

/// An EfficientNeRF model. Densities are optical depths of a fine cell's edge.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct EfficientNerf {
    tables: [Table; 1],
    nodes: Nodes,
    corner: DVec3,
    /// Edge of a fine cell in world units.
    cell: f64,
}

impl EfficientNerf {
    /// Samples a model of `cells` coarse cells along each axis from `corner` on, at the centres of
    /// fine cells of edge `cell`. `fill` writes the channels of a fine cell and returns whether it
    /// is non-empty. Coarse cells without such a fine cell have no node.
    ///
    /// # Errors
    /// The sizes are out of range for a table, or a value is not finite.
    pub fn sampled(
        cells: [usize; 3],
        corner: DVec3,
        cell: f64,
        fill: impl Fn(DVec3, &mut [f32; CHANNELS]) -> bool + Sync,
    ) -> Result<Self, FieldError> {
        let centre = |coarse: [usize; 3], fine: usize| {
            let own = [fine % FINE, fine / FINE % FINE, fine / (FINE * FINE)];
            let at = [0, 1, 2].map(|axis| (coarse[axis] * FINE + own[axis]) as f64 + 0.5);
            corner + cell * DVec3::from(at)
        };
        let node = |coarse: [usize; 3]| {
            let mut values = vec![0f32; FINE.pow(3) * CHANNELS];
            let mut filled = false;
            for (fine, to) in values.as_chunks_mut::<CHANNELS>().0.iter_mut().enumerate() {
                to[0] = EMPTY;
                filled |= fill(centre(coarse, fine), to);
            }
            filled.then_some(values)
        };
        let [x, y, z] = cells;
        let planes: Vec<Vec<Option<Vec<f32>>>> = (0..z)
            .into_par_iter()
            .map(|k| (0..x * y).map(|i| node([i % x, i / x, k])).collect())
            .collect();
        let nodes = Nodes::new(cells, FINE, |[i, j, k]| planes[k][i + x * j].is_some());
        let values = planes.into_iter().flatten().flatten().flatten();
        Ok(Self {
            tables: [Table::tree(nodes.clone(), CHANNELS, values.collect())?],
            nodes,
            corner,
            cell,
        })
    }

    /// Number of coarse cells with a node, and of all coarse cells.
    #[must_use]
    pub fn occupancy(&self) -> [usize; 2] {
        let filled = self.nodes.rows() / FINE.pow(3);
        [filled, self.nodes.cells().iter().product()]
    }
}

/// Description of the algorithm for reports.
pub static ALGORITHM: Algorithm = Algorithm {
    name: "EfficientNeRF",
    outside: &[
        unverified_work::INDEXING,
        unverified_work::NODES,
        unverified_work::RIT,
        unverified_work::HARMONICS,
        unverified_work::COEFFICIENTS,
        unverified_work::COMPOSITING,
    ],
    full_size: Some(Size::Cells {
        coarse: 384,
        fine: FINE,
    }),
    preset: "fields",
    file: None,
};

impl Field for EfficientNerf {
    fn algorithm(&self) -> &'static Algorithm {
        &ALGORITHM
    }

    fn tables(&self) -> &[Table] {
        &self.tables
    }

    fn place(&self, at: DVec3, places: &mut [DVec3]) {
        places[0] = (at - self.corner) / self.cell;
    }

    fn holds(&self, at: DVec3) -> bool {
        let fine = self.nodes.cell((at - self.corner) / self.cell);
        self.nodes.row(fine).is_some()
    }

    fn depth(&self, features: &[f64]) -> f64 {
        STEP * softplus(features[0])
    }

    fn colour(&self, features: &[f64], direction: DVec3, _: &mut Vec<f64>) -> DVec3 {
        let basis = sh::basis(direction);
        let channel = |c: usize| {
            let own = &features[1 + c * COEFFICIENTS..][..COEFFICIENTS];
            let logit: f64 = own.iter().zip(basis).map(|(v, b)| v * b).sum();
            1.0 / (1.0 + (-logit).exp())
        };
        dvec3(channel(0), channel(1), channel(2))
    }

    fn directions(&self) -> Directions<'_> {
        let rows = self.tables[0].values().chunks_exact(CHANNELS);
        let holders = rows.map(|row| {
            let colours = row[1..].chunks_exact(COEFFICIENTS);
            colours.fold([false; sh::MAX_DEGREE + 1], |mut all, colour| {
                let own = sh_degrees::used(colour.iter().map(std::slice::from_ref));
                all.iter_mut().zip(own).for_each(|(to, own)| *to |= own);
                all
            })
        });
        Directions::Harmonics {
            bands: Bands::of(COEFFICIENTS.isqrt() - 1, holders),
            holders: "fine cells",
        }
    }

    fn void(&self) -> Option<[u64; 2]> {
        let [filled, cells] = self.occupancy().map(|n| n as u64);
        Some([cells - filled, cells])
    }

    fn sampling(&self) -> Sampling {
        let size = DVec3::from(self.nodes.points().map(|p| p as f64));
        Sampling {
            bounds: [self.corner, self.corner + self.cell * size],
            step: STEP * self.cell,
            range: [0.0, f64::INFINITY],
            along: Along::Ray,
            least_opacity: 0.0,
            least_weight: LEAST_WEIGHT,
            stop: STOP,
        }
    }

    fn coded(&self, config: &Config) -> Result<QuantisedField<'_>, FieldError> {
        fixed::coded(self, config)
    }

    fn bounds(
        &self,
        config: &Config,
        vector: &VectorBounds,
        _: &Camera,
    ) -> Result<Option<Box<dyn Bounds + '_>>, FieldError> {
        Ok(Some(Box::new(bound::bounds(self, config, vector)?)))
    }
}
