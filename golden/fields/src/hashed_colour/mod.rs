//! The colour of Compact-3DGS (Lee et al., CVPR 2024): a perceptron of hash-grid features at a
//! Gaussian's centre and harmonics of the viewing direction.
//!
//! It has the stages of a [`Field`](super::Field), without density, which a Gaussian has itself.
//! [`HashedColour::index`] returns the position in each table, the tables are gathered as any
//! others, and [`HashedColour::colour`] computes a colour from the features.

mod bound;
mod fixed;

use glam::DVec3;

use super::{FieldError, HashUnit, Layer, Mlp, Table};
use crate::algorithms::ngp::grid::GridShape;
use crate::algorithms::ngp::level_table;
use potamoi_base::sh;

pub use fixed::FixedColour;

/// Number of levels.
const LEVELS: u32 = 16;
/// Features an entry.
const FEATURES: u32 = 2;
/// Number of harmonics: bands 0 to 2, which tiny-cuda-nn calls degree 3.
const HARMONICS: usize = 9;
/// Outputs and inputs of the network's matrices as tiny-cuda-nn stores them, rounded up to 16.
const MATRICES: [[usize; 2]; 3] = [[64, 48], [64, 64], [16, 64]];
/// Number of padding inputs. They are 1, and so act as a bias.
const ONES: usize = MATRICES[0][1] - (LEVELS * FEATURES) as usize - HARMONICS;
/// Logarithm to base 2 of the largest supported number of entries in a level.
const MAX_LOG2: u32 = 24;

/// Number of stored parameters of the network.
const NETWORK: usize = 64 * 48 + 64 * 64 + 16 * 64;

/// A colour that depends on position and direction.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct HashedColour {
    shape: GridShape,
    tables: Vec<Table>,
    /// The scale of each level.
    scales: Vec<f64>,
    head: Mlp,
}

const fn shape(log2_entries: u32) -> GridShape {
    GridShape {
        levels: LEVELS,
        features: FEATURES,
        log2_entries,
        base: 16,
        growth: 1.447,
    }
}

fn stored(shape: &GridShape) -> usize {
    let entries: usize = shape.all().map(|level| level.entries).sum();
    entries * shape.features as usize
}

impl HashedColour {
    /// Builds the field from parameters as tiny-cuda-nn stores them: `grid` level after level,
    /// whose length determines the size of the tables, and `network` matrix after matrix, a row an
    /// output: 64 x 48, 64 x 64, 16 x 64.
    ///
    /// # Errors
    /// The number of parameters is wrong, or one is not finite.
    pub fn new(grid: &[f32], network: &[f32]) -> Result<Self, FieldError> {
        let refuse = |part, found: usize, expected: String| {
            Err(FieldError::Part {
                part,
                found: format!("{found} parameters"),
                expected,
            })
        };
        let Some(shape) = (3..=MAX_LOG2).map(shape).find(|s| stored(s) == grid.len()) else {
            let known: Vec<_> = [16, 19].map(|l| stored(&shape(l)).to_string()).to_vec();
            let expected = format!(
                "as many as 16 levels of 2^3 to 2^{MAX_LOG2} entries have, such as {}",
                known.join(" and ")
            );
            return refuse("hash", grid.len(), expected);
        };
        if network.len() != NETWORK {
            let expected = format!("{NETWORK}: matrices of 64 x 48, 64 x 64 and 16 x 64");
            return refuse("mlp", network.len(), expected);
        }
        let (mut tables, mut rest) = (vec![], grid);
        for level in shape.all() {
            let (own, after) = rest.split_at(level.entries * FEATURES as usize);
            let own = own.to_vec();
            tables.push(level_table(
                &level,
                HashUnit::Vertex,
                FEATURES as usize,
                own,
            )?);
            rest = after;
        }
        let mut rest = network;
        let mut layers = vec![];
        for (i, [rows, columns]) in MATRICES.into_iter().enumerate() {
            let (own, after) = rest.split_at(rows * columns);
            // Of the last, red, green and blue; the others only fill up.
            let kept = if i + 1 == MATRICES.len() { 3 } else { rows };
            let weights = own[..kept * columns].to_vec();
            layers.push(Layer::new(columns, weights, vec![0.0; kept])?);
            rest = after;
        }
        Ok(Self {
            shape,
            scales: shape.all().map(|level| level.scale).collect(),
            tables,
            head: Mlp::new(layers)?,
        })
    }

    /// Sizes of the hash grid.
    #[must_use]
    pub const fn shape(&self) -> &GridShape {
        &self.shape
    }

    /// The tables, one a level.
    #[must_use]
    pub fn tables(&self) -> &[Table] {
        &self.tables
    }

    /// The network, with 32 features, 9 harmonics and 7 ones as inputs.
    #[must_use]
    pub const fn head(&self) -> &Mlp {
        &self.head
    }

    /// Inputs of the network that encode the direction: harmonics, from degree 0 on.
    #[must_use]
    pub fn direction_inputs() -> Vec<usize> {
        let first = (LEVELS * FEATURES) as usize;
        (first..first + HARMONICS).collect()
    }

    /// The position of a world point in each table, in vertices. All of space is mapped to the
    /// unit cube: points within 1 of the origin to the middle half, the others around it.
    pub fn index(&self, at: DVec3, places: &mut [DVec3]) {
        let within = contracted(at) / 4.0 + 0.5;
        for (place, scale) in places.iter_mut().zip(&self.scales) {
            *place = within * *scale + 0.5;
        }
    }

    /// The coefficient of the constant harmonic of each channel, from gathered features and the
    /// unit direction from the camera. `scratch` is a buffer that is reused from call to call.
    pub fn colour(&self, features: &[f64], direction: DVec3, scratch: &mut Vec<f64>) -> DVec3 {
        scratch.clear();
        scratch.extend_from_slice(features);
        scratch.extend(harmonics(direction));
        scratch.extend([1.0; ONES]);
        self.head.run(scratch);
        DVec3::new(scratch[0], scratch[1], scratch[2])
    }

    /// [`HashedColour::colour`] at a world point, gathered from all tables.
    pub fn at(&self, at: DVec3, direction: DVec3, scratch: &mut Vec<f64>) -> DVec3 {
        let mut features = Vec::with_capacity((LEVELS * FEATURES) as usize);
        self.gathered(at, &mut features);
        self.colour(&features, direction, scratch)
    }

    /// Appends the features at a point.
    fn gathered(&self, at: DVec3, features: &mut Vec<f64>) {
        let mut places = [DVec3::ZERO; LEVELS as usize];
        self.index(at, &mut places);
        for (table, place) in self.tables.iter().zip(places) {
            let mut own = [0.0; FEATURES as usize];
            table.gather(place, &mut own);
            features.extend(own);
        }
    }
}

/// Contracts space into a ball of radius 2: `(2 - 1/|x|) x/|x|` beyond 1 (Barron et al., Mip-NeRF
/// 360, CVPR 2022).
fn contracted(at: DVec3) -> DVec3 {
    let length = at.length();
    if length <= 1.0 {
        return at;
    }
    (2.0 - 1.0 / length) * (at / length)
}

/// Harmonics of a direction as Compact-3DGS evaluates them. The encoding of tiny-cuda-nn expects
/// directions in the unit cube and maps them by 2 d - 1. Compact-3DGS passes the direction itself,
/// and is trained that way. The result is not a unit vector, so the polynomial of order 0 in band
/// 2 differs from the homogeneous one.
fn harmonics(direction: DVec3) -> [f64; HARMONICS] {
    let moved = 2.0 * direction - 1.0;
    let all = sh::basis(moved);
    let mut out = [0.0; HARMONICS];
    out.copy_from_slice(&all[..HARMONICS]);
    out[6] = 0.315_391_565_252_520_05 * (3.0 * moved.z * moved.z - 1.0);
    out
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn space_is_contracted_into_the_cube() {
        for (at, expected) in [
            ([0.0, 0.0, 0.0], [0.5, 0.5, 0.5]),
            ([1.0, 0.0, 0.0], [0.75, 0.5, 0.5]),
            ([0.0, -2.0, 0.0], [0.5, 0.5 - 1.5 / 4.0, 0.5]),
            ([0.0, 0.0, 1e30], [0.5, 0.5, 1.0]),
        ] {
            let found = contracted(DVec3::from(at)) / 4.0 + 0.5;
            assert!((found - DVec3::from(expected)).length() < 1e-12, "{found}");
        }
    }

    /// On a direction that 2 d - 1 keeps, they are those of 3DGS: no unit
    /// vector but (1, 0, 0) and the like, where d = (1, 1/2, 1/2).
    #[test]
    fn harmonics_are_of_the_moved_direction() {
        let found = harmonics(DVec3::new(1.0, 0.5, 0.5));
        let unit = sh::basis(DVec3::X);
        for (a, b) in found.iter().zip(unit) {
            assert!((a - b).abs() < 1e-12, "{found:?}");
        }
        // At d = 0, of (-1, -1, -1): 3 z^2 - 1 is 2, the homogeneous one 0.
        assert!((harmonics(DVec3::ZERO)[6] - 2.0 * 0.315_391_565_252_520_05).abs() < 1e-12);
    }

    /// Ones are a bias, and rows past the third fill up.
    #[test]
    fn parameters_are_laid_out_as_stored() {
        let shape = shape(3);
        let grid = vec![0.0; stored(&shape)];
        let mut network = vec![0.0; NETWORK];
        // The first hidden neuron is the sum of the ones, 7.
        network[41..48].fill(1.0);
        network[64 * 48] = 1.0;
        for (row, weight) in [(0, 0.5), (1, -1.0), (2, 2.0), (3, 99.0)] {
            network[64 * 48 + 64 * 64 + row * 64] = weight;
        }
        let made = HashedColour::new(&grid, &network).unwrap();
        let mut scratch = vec![];
        let found = made.at(DVec3::ONE, DVec3::X, &mut scratch);
        assert_eq!(found, DVec3::new(3.5, -7.0, 14.0));
        assert_eq!((made.shape().log2_entries, made.tables().len()), (3, 16));
        let error = HashedColour::new(&grid[1..], &network).unwrap_err();
        assert!(error.to_string().contains("255 parameters"), "{error}");
        let error = HashedColour::new(&grid, &network[1..]).unwrap_err();
        assert!(error.to_string().contains("8191 parameters"), "{error}");
    }

    /// In the hardware's formats the ones are exactly one: off by 1/256, each of
    /// them alone would show, and so would any other input that is not 0.
    #[test]
    fn ones_are_exactly_one_in_codes() {
        let config = potamoi_formats::config::Config::preset("fields").unwrap();
        // Features of 1/2 have 15 fraction bits: ones have to give way.
        let grid = vec![0.5; stored(&shape(3))];
        let mut made = vec![];
        for column in 41..48 {
            let mut network = vec![0.0; NETWORK];
            network[column] = 1.0;
            network[64 * 48] = 1.0;
            for (row, weight) in [0.5, 1.0, -1.0].into_iter().enumerate() {
                network[64 * 48 + 64 * 64 + row * 64] = weight;
            }
            made.push(HashedColour::new(&grid, &network).unwrap());
        }
        let centres = [DVec3::ZERO, DVec3::new(0.3, -2.0, 5.0)];
        for field in made {
            let fixed = FixedColour::new(&field, &centres, &config).unwrap();
            let mut units = potamoi_reference::ReferenceUnits::new(&config);
            let mut stats = potamoi_march::FixedStats::default();
            let found = fixed.seen_from(
                DVec3::Z * 9.0,
                &centres,
                crate::FieldWork::ALL,
                &mut units,
                &mut stats,
            );
            for colour in found.unwrap() {
                for (found, expected) in colour.into_iter().zip([0.5, 1.0, -1.0]) {
                    assert!((found - expected).abs() < 1.0 / 1024.0, "{colour:?}");
                }
            }
        }
    }

    /// Every size is told from its number of parameters.
    #[test]
    fn sizes_have_different_numbers_of_parameters() {
        let counts: Vec<_> = (3..=MAX_LOG2).map(|l| stored(&shape(l))).collect();
        assert!(counts.is_sorted_by(|a, b| a < b), "{counts:?}");
        assert_eq!(counts[0], 16 * 8 * 2);
    }
}
