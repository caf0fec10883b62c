//! A model with the sizes of the original base configuration, for counts: the field of another hash
//! grid in generated tables and perceptrons.
//!
//! Accesses depend on sizes, and on densities alone beside them. So the densities, and a brightness,
//! are those of the other grid as far as levels without many collisions hold them: each level stores
//! the difference from the coarser ones, as a pyramid does. Finer levels have small random values, as
//! before training. Weights of the perceptrons carry both numbers to the outputs, the others are 0.

use glam::DVec3;
use rand::{Rng as _, SeedableRng as _};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use super::grid::{GridShape, Level};
use super::{Ngp, level_table};
use crate::calibrate::Magnitudes;
use crate::{FieldError, HashUnit, Layer, Mlp};
use potamoi_base::sh;

/// The grid of the original's base configuration (Müller et al. 2022, table 1 and configs/nerf/base.json).
const LEVELS: u32 = 16;
const FEATURES: u32 = 2;
const LOG2_ENTRIES: u32 = 19;
const BASE: u32 = 16;
/// Widths of its perceptrons, for density and for colour.
const DENSITY: [usize; 3] = [32, 64, 16];
const COLOUR: [usize; 4] = [32, 64, 64, 3];
/// Vertices along an axis from which on a level has random values: more vertices near surfaces than
/// entries.
const RANDOM_FROM: u64 = 128;
/// Largest random value, as the original begins its training with.
const RANDOM: f32 = 1e-4;
/// Range of the logarithm of the density: from a step of no opacity to one of no transmittance.
const DENSITIES: [f64; 2] = [-5.0, 10.0];
/// Range of the brightness's logit.
const BRIGHTNESSES: [f64; 2] = [-4.0, 4.0];

impl Ngp {
    /// A model of this field with the sizes of the original's base configuration: 16 levels of 2^19
    /// entries of 2 features, up to 2048 vertices along an axis. It has the same empty cells and, up
    /// to details finer than 1/128 of the cube, the same densities; colours are grey.
    ///
    /// # Errors
    /// None in practice: sizes and values are valid by construction.
    pub fn full_size(&self) -> Result<Self, FieldError> {
        let shape = GridShape {
            levels: LEVELS,
            features: FEATURES,
            log2_entries: LOG2_ENTRIES,
            base: BASE,
            growth: GridShape::growth_to(LEVELS, BASE, self.side as u32),
        };
        let mut made = Self {
            shape,
            unit: HashUnit::Vertex,
            tables: vec![],
            scales: vec![],
            density: carrying(&DENSITY, &[(by_level(0), vec![0]), (by_level(1), vec![1])])?,
            colour: carrying(&COLOUR, &[(vec![1], vec![0, 1, 2])])?,
            magnitudes: Magnitudes::default(),
            ..self.clone()
        };
        let mut random = Pcg64Mcg::seed_from_u64(0);
        for level in shape.all() {
            let values = match level.resolution < RANDOM_FROM {
                true => self.differences(&made, &level),
                false => {
                    let count = level.entries * FEATURES as usize;
                    (0..count)
                        .map(|_| random.random_range(-RANDOM..RANDOM))
                        .collect()
                }
            };
            let table = level_table(&level, HashUnit::Vertex, FEATURES as usize, values)?;
            made.tables.push(table);
            made.scales.push(level.scale);
        }
        Ok(made)
    }

    /// The differences of this field's numbers from those of the levels that `made` has, entry by
    /// entry: the mean of the vertices that share one.
    fn differences(&self, made: &Self, level: &Level) -> Vec<f32> {
        let side = level.resolution as usize;
        let slices: Vec<Vec<(usize, [f64; 2])>> = (0..side)
            .into_par_iter()
            .map(|z| {
                let rows = (0..side * side).map(|i| [i % side, i / side, z]);
                let found = rows.filter_map(|vertex| {
                    let own = vertex.map(|v| (v as f64 - 0.5) / level.scale);
                    let within = DVec3::from(own).clamp(DVec3::ZERO, DVec3::ONE);
                    let edge = self.side / level.scale;
                    self.is_near(self.corner + self.side * within, edge)
                        .then(|| {
                            let row = match level.is_hashed() {
                                true => HashUnit::Vertex.row(vertex, level.entries),
                                false => vertex[0] + side * (vertex[1] + side * vertex[2]),
                            };
                            let coarser = made.carried(within);
                            let own = self.numbers(within);
                            (row, [0, 1].map(|i| own[i] - coarser[i]))
                        })
                });
                found.collect()
            })
            .collect();
        let mut sums = vec![[0.0; 3]; level.entries];
        for (row, values) in slices.into_iter().flatten() {
            let sum = &mut sums[row];
            *sum = [sum[0] + values[0], sum[1] + values[1], sum[2] + 1.0];
        }
        let means = sums
            .into_iter()
            .flat_map(|[a, b, n]| [a, b].map(|v| (v / n.max(1.0)) as f32));
        means.collect()
    }

    /// Whether the field may be non-empty within `edge` of a position, per axis, in the cube's frame.
    fn is_near(&self, at: DVec3, edge: f64) -> bool {
        let Some(occupancy) = &self.occupancy else {
            return true;
        };
        // Of coarse levels all vertices are few.
        let cell = 1.0 / f64::from(super::occupancy::CELLS);
        if edge > 2.0 * cell {
            return true;
        }
        // No farther apart than a cell.
        let places =
            (0..125usize).map(|i| [i % 5, i / 5 % 5, i / 25].map(|v| v as f64 / 2.0 - 1.0));
        let mut places = places.map(|place| at + edge * DVec3::from(place));
        places.any(|place| occupancy.holds(place))
    }

    /// Logarithm of the density, and logit of the brightness from above, at a position in the grid.
    fn numbers(&self, within: DVec3) -> [f64; 2] {
        let mut features = vec![0.0; self.tables.len() * self.shape.features as usize];
        self.gather_all(within, &mut features);
        let mut values = vec![];
        self.latents(&features, &mut values);
        let density = values[0];
        values.extend(sh::basis(DVec3::NEG_Z));
        self.colour.run(&mut values);
        let brightness = (values[0] + values[1] + values[2]) / 3.0;
        let within = |v: f64, [low, high]: [f64; 2]| v.clamp(low, high);
        [within(density, DENSITIES), within(brightness, BRIGHTNESSES)]
    }

    /// The sums over the levels so far.
    fn carried(&self, within: DVec3) -> [f64; 2] {
        let mut features = vec![0.0; self.tables.len() * FEATURES as usize];
        self.gather_all(within, &mut features);
        let sum = |i: usize| features.iter().skip(i).step_by(FEATURES as usize).sum();
        [sum(0), sum(1)]
    }

    /// Gathers from all tables so far.
    fn gather_all(&self, within: DVec3, features: &mut [f64]) {
        let each = features.chunks_exact_mut(self.shape.features as usize);
        for ((table, scale), own) in self.tables.iter().zip(&self.scales).zip(each) {
            table.gather(within * *scale + 0.5, own);
        }
    }
}

/// A feature of each level.
fn by_level(feature: usize) -> Vec<usize> {
    (0..LEVELS as usize)
        .map(|level| level * FEATURES as usize + feature)
        .collect()
}

/// A perceptron of these widths whose outputs are sums of inputs: each sum with the outputs that have
/// it. Two neurons a layer carry a sum through ReLU, one where it is positive, one where it is not.
fn carrying(widths: &[usize], sums: &[(Vec<usize>, Vec<usize>)]) -> Result<Mlp, FieldError> {
    let last = widths.len() - 2;
    let layers = widths.windows(2).enumerate().map(|(at, sizes)| {
        let [inputs, outputs] = [sizes[0], sizes[1]];
        let mut weights = vec![0.0; inputs * outputs];
        for (i, (from, to)) in sums.iter().enumerate() {
            let pair = [(2 * i, 1.0), (2 * i + 1, -1.0)];
            for (neuron, sign) in pair {
                match at {
                    0 => from
                        .iter()
                        .for_each(|input| weights[neuron * inputs + input] = sign),
                    _ if at == last => to
                        .iter()
                        .for_each(|out| weights[out * inputs + neuron] = sign),
                    _ => weights[neuron * inputs + neuron] = 1.0,
                }
            }
        }
        Layer::new(inputs, weights, vec![0.0; outputs])
    });
    Mlp::new(layers.collect::<Result<_, _>>()?)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// Sums of both signs pass all layers, and no other output has anything.
    #[test]
    fn sums_are_carried_to_their_outputs() {
        let sums = [(vec![0, 2], vec![1]), (vec![1], vec![0, 3])];
        let mlp = carrying(&[3, 8, 8, 4], &sums).unwrap();
        for [a, b, c] in [[1.0, 2.0, 3.0], [-1.0, 0.5, -4.0], [2.0, -3.0, -2.0]] {
            let mut values = vec![a, b, c];
            mlp.run(&mut values);
            assert_eq!(values, [b, a + c, 0.0, b]);
        }
    }
}
