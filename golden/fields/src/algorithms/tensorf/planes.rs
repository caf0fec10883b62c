//! Vector-matrix factors of functions that matter only at some vertices of a grid: those around
//! visible parts.
//!
//! The lines are fixed: half of them are cosines, which suit smooth functions, half are seeded
//! random numbers. The planes remain, and enter linearly. Around a surface few vertices lie in
//! each column of the grid, fewer than a mode has terms, and random lines distinguish them. So the
//! planes through all known values are found in a few rounds of conjugate gradients (CGLS:
//! Hestenes and Stiefel 1952). Elsewhere the factors have arbitrary values, and the mask marks the
//! space as empty.

use rayon::prelude::*;

use super::mask::AlphaMask;
use super::{LINES, PLANES, Rules, Tensorf, part};
use crate::{FieldError, Layer, Mlp, Table};

/// Maximum number of rounds of conjugate gradients.
const ROUNDS: usize = 40;
/// Relative size of the residual at which the rounds end.
const ENOUGH: f64 = 1e-3;
/// Errors of densities are weighted by one over the sum of their size and this.
const LIGHT: f32 = 0.5;
/// Weight of the planes' own size against errors.
const DAMPING: f32 = 1e-3;

/// Known values of functions at vertices of a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct KnownValues {
    /// Number of vertices of the grid along x, y, z.
    pub points: [usize; 3],
    /// Vertices with a known density.
    pub places: Vec<[usize; 3]>,
    /// The densities there, before activation. Small ones, at which the activation bends and of
    /// which fog consists, are fitted more closely.
    pub density: Vec<f32>,
    /// Vertices with a known appearance.
    pub seen: Vec<[usize; 3]>,
    /// Channels of appearance, each with one value for each vertex of `seen`.
    pub appearance: Vec<Vec<f32>>,
    /// Whether the field may be non-empty around a vertex, for all vertices, x fastest.
    pub filled: Vec<bool>,
}

/// Planes of one function, one a mode, with the terms of a vertex side by side.
type Planes = [Vec<f32>; 3];

/// Lines of one function, one a mode, with the terms of a vertex side by side.
struct Lines {
    terms: usize,
    points: [usize; 3],
    values: [Vec<f32>; 3],
}

impl Lines {
    /// Random lines. Their squares sum to about 1 over all modes.
    fn new(points: [usize; 3], terms: usize, mut seed: u64) -> Self {
        let mut uniform = || {
            // SplitMix64 (Steele, Lea and Flood 2014).
            seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = seed;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        };
        let scale = 1.0 / (3.0 * terms as f64).sqrt();
        let values = LINES.map(|axis| {
            let length = points[axis] as f64;
            let value = |i: usize| {
                let (vertex, term) = (i / terms, i % terms);
                let value = if term < terms / 2 {
                    // Those of the discrete cosine transform.
                    let turn = std::f64::consts::PI * term as f64 / length;
                    2f64.sqrt() * (turn * (vertex as f64 + 0.5)).cos()
                } else {
                    // Of variance 1, near to normally distributed.
                    2.0 * (uniform() + uniform() + uniform() - 1.5)
                };
                (value * scale) as f32
            };
            (0..points[axis] * terms).map(value).collect()
        });
        Self {
            terms,
            points,
            values,
        }
    }

    /// Index of a vertex's first term in the line and in the plane of a mode.
    fn place(&self, mode: usize, vertex: [usize; 3]) -> [usize; 2] {
        let [a, b] = PLANES[mode];
        let plane = vertex[a] + self.points[a] * vertex[b];
        [vertex[LINES[mode]] * self.terms, plane * self.terms]
    }

    fn empty(&self) -> Planes {
        PLANES.map(|[a, b]| vec![0.0; self.points[a] * self.points[b] * self.terms])
    }

    /// The weighted values of the planes at vertices.
    fn apply(&self, planes: &Planes, at: &[[usize; 3]], weights: &[f32], out: &mut [f32]) {
        for ((to, vertex), weight) in out.iter_mut().zip(at).zip(weights) {
            let mut value = 0.0;
            for mode in 0..3 {
                let [line, plane] = self.place(mode, *vertex);
                let line = &self.values[mode][line..][..self.terms];
                let plane = &planes[mode][plane..][..self.terms];
                value += dot(line, plane);
            }
            *to = value * weight;
        }
    }

    /// The transpose of `apply`, less damping.
    fn transpose(
        &self,
        values: &[f32],
        at: &[[usize; 3]],
        weights: &[f32],
        planes: &Planes,
    ) -> Planes {
        let mut out = planes.clone();
        for own in out.iter_mut().flatten() {
            *own *= -DAMPING;
        }
        for ((value, vertex), weight) in values.iter().zip(at).zip(weights) {
            let value = value * weight;
            for mode in 0..3 {
                let [line, plane] = self.place(mode, *vertex);
                let line = &self.values[mode][line..][..self.terms];
                let plane = &mut out[mode][plane..][..self.terms];
                for (sum, l) in plane.iter_mut().zip(line) {
                    *sum += value * l;
                }
            }
        }
        out
    }

    /// Planes fitted to values at vertices by weighted least squares.
    fn planes(&self, at: &[[usize; 3]], values: &[f32], weights: &[f32]) -> Planes {
        let mut planes = self.empty();
        let mut left: Vec<f32> = values.iter().zip(weights).map(|(v, w)| v * w).collect();
        let mut slope = self.transpose(&left, at, weights, &planes);
        let mut towards = slope.clone();
        let mut size = square(slope.iter().flatten());
        let mut step = vec![0.0; at.len()];
        let enough = ENOUGH * ENOUGH * square(left.iter());
        for _ in 0..ROUNDS {
            self.apply(&towards, at, weights, &mut step);
            let length =
                square(step.iter()) + f64::from(DAMPING) * square(towards.iter().flatten());
            if length <= 0.0 {
                break;
            }
            let share = (size / length) as f32;
            add(&mut planes, share, &towards);
            for (left, step) in left.iter_mut().zip(&step) {
                *left -= share * step;
            }
            if square(left.iter()) <= enough {
                break;
            }
            slope = self.transpose(&left, at, weights, &planes);
            let next = square(slope.iter().flatten());
            let keep = (next / size) as f32;
            size = next;
            for (to, own) in towards.iter_mut().zip(&slope) {
                for (to, own) in to.iter_mut().zip(own) {
                    *to = own + keep * *to;
                }
            }
        }
        planes
    }
}

/// Dot product in four interleaved sums, which processors can add at once.
fn dot(a: &[f32], b: &[f32]) -> f32 {
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [0f32; 4];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..4 {
            sums[lane] += a[lane] * b[lane];
        }
    }
    let rest: f32 = rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

fn square<'a>(values: impl Iterator<Item = &'a f32>) -> f64 {
    values.map(|v| f64::from(*v) * f64::from(*v)).sum()
}

fn add(to: &mut Planes, share: f32, from: &Planes) {
    for (to, from) in to.iter_mut().flatten().zip(from.iter().flatten()) {
        *to += share * from;
    }
}

impl Tensorf {
    /// A model fitted to known values, with `ranks` terms a mode of density and of appearance, the
    /// latter shared evenly among its channels. Channel `c` of appearance becomes feature
    /// `slots[c]` of `features`; the others are 0.
    ///
    /// # Errors
    /// There are fewer terms than channels, a slot or vertex is out of range, lists differ in
    /// length, or parts do not fit.
    pub fn through(
        known: &KnownValues,
        ranks: [usize; 2],
        (features, slots): (usize, &[usize]),
        mlp: Mlp,
        rules: Rules,
    ) -> Result<Self, FieldError> {
        let points = known.points;
        let channels = known.appearance.len();
        check(known, ranks, features, slots)?;
        let own = |c: usize| ranks[1] / channels + usize::from(c < ranks[1] % channels);
        let weights = known.density.iter().map(|v| 1.0 / (LIGHT + v.abs()));
        let weights: Vec<f32> = weights.collect();
        let even = vec![1.0; known.seen.len()];
        // The density, then the channels: vertices, values, weights, terms.
        let mut functions = vec![(&known.places, &known.density, &weights, ranks[0])];
        for (c, values) in known.appearance.iter().enumerate() {
            functions.push((&known.seen, values, &even, own(c)));
        }
        let fitted: Vec<(Lines, Planes)> = (0u64..)
            .zip(functions)
            .collect::<Vec<_>>()
            .into_par_iter()
            .map(|(seed, (at, values, weights, terms))| {
                let lines = Lines::new(points, terms, seed);
                let planes = lines.planes(at, values, weights);
                (lines, planes)
            })
            .collect();

        let all = ranks[0] + ranks[1];
        let mut tables = vec![];
        for is_line in [false, true] {
            for mode in 0..3 {
                let [a, b] = PLANES[mode].map(|axis| points[axis]);
                let sides = if is_line {
                    [points[LINES[mode]], 1, 1]
                } else {
                    [a, b, 1]
                };
                let mut values = Vec::with_capacity(sides[0] * sides[1] * all);
                for vertex in 0..sides[0] * sides[1] {
                    for (lines, planes) in &fitted {
                        let from = if is_line { &lines.values } else { planes };
                        values
                            .extend_from_slice(&from[mode][vertex * lines.terms..][..lines.terms]);
                    }
                }
                tables.push(Table::new(sides, all, values)?);
            }
        }
        let Ok(tables) = <[Table; 6]>::try_from(tables) else {
            return Err(part("tables", "not six".to_owned(), "six"));
        };
        let products = 3 * ranks[1];
        let mut basis = vec![0.0; features * products];
        for mode in 0..3 {
            let mut first = mode * ranks[1];
            for (c, slot) in slots.iter().enumerate() {
                basis[slot * products + first..][..own(c)].fill(1.0);
                first += own(c);
            }
        }
        let basis = Layer::new(products, basis, vec![0.0; features])?;
        let mut made = Self::new(tables, [ranks[0]; 3], basis, mlp, rules)?;
        made.mask = Some(AlphaMask {
            points,
            bounds: rules.bounds,
            filled: known.filled.clone(),
        });
        Ok(made)
    }
}

fn check(
    known: &KnownValues,
    ranks: [usize; 2],
    features: usize,
    slots: &[usize],
) -> Result<(), FieldError> {
    let channels = known.appearance.len();
    if channels == 0 || slots.len() != channels || slots.iter().any(|s| *s >= features) {
        let expected = format!("one below {features} for each of the {channels} channels");
        return Err(part("slots", format!("{slots:?}"), expected));
    }
    if ranks[0] == 0 || ranks[1] < channels || ranks.iter().any(|r| *r > 1024) {
        let expected = format!("1 to 1024 of density, {channels} to 1024 of appearance");
        return Err(part("ranks", format!("{ranks:?}"), expected));
    }
    let places = known.places.iter().chain(&known.seen);
    let inside = |at: &[usize; 3]| (0..3).all(|axis| at[axis] < known.points[axis]);
    if let Some(at) = places.into_iter().find(|at| !inside(at)) {
        let expected = format!("within {:?} vertices", known.points);
        return Err(part("vertices", format!("{at:?}"), expected));
    }
    let seen = known.seen.len();
    let vertices: usize = known.points.iter().product();
    let fits = known.appearance.iter().all(|v| v.len() == seen);
    if !fits || known.density.len() != known.places.len() || known.filled.len() != vertices {
        let found = format!("{} bits", known.filled.len());
        let expected =
            format!("a density a place, {seen} values a channel of appearance, {vertices} bits");
        return Err(part("known", found, expected));
    }
    Ok(())
}

#[cfg(test)]
#[path = "planes_tests.rs"]
mod tests;
