//! Vector-matrix factors of a function that is known at all vertices of a grid.
//!
//! The modes are fitted in turn, each to what the others leave (block coordinate
//! descent), so that the error never grows. The best terms of a mode are the
//! first singular vectors of what is left, unfolded along the mode's line
//! (Eckart and Young 1936). Functions of several channels are fitted channel by
//! channel, and their terms are shared out evenly: a function of `n` terms a
//! mode comes back from `n` terms a mode and channel. Terms that are weak beside
//! others are found slowly, and may be missing when the rounds are over.
//!
//! Singular vectors are eigenvectors of Gram matrices, whose sides are those of
//! the grid: results depend on the numbers alone.

use rayon::prelude::*;

use super::eigen::eigen;
use super::{LINES, PLANES, Rules, Tensorf, part};
use crate::fields::{FieldError, Layer, Mlp, Table};

/// The most vertices along an axis.
const MAX_POINTS: usize = 1 << 9;
/// The most channels.
const MAX_CHANNELS: usize = 1 << 8;
/// The most values.
const MAX_VALUES: usize = 1 << 28;
/// The most rounds through all modes.
const SWEEPS: usize = 400;
/// Relative error at which no more is asked for.
const EXACT: f64 = 1e-9;
/// Share of the error that a round takes away at least, or it was the last.
const GAIN: f64 = 1e-5;

/// A function of several channels at all vertices of a grid.
#[derive(Debug, Clone, PartialEq)]
pub struct Dense {
    points: [usize; 3],
    channels: usize,
    values: Vec<f64>,
}

impl Dense {
    /// The function that `value` writes, given a vertex along x, y, z.
    ///
    /// # Errors
    /// Sizes out of range, or a value that is not finite.
    pub fn sampled(
        points: [usize; 3],
        channels: usize,
        mut value: impl FnMut([usize; 3], &mut [f64]),
    ) -> Result<Self, FieldError> {
        if points.iter().any(|p| !(2..=MAX_POINTS).contains(p)) {
            let expected = format!("2 to {MAX_POINTS} vertices along each axis");
            return Err(part("points", format!("{points:?}"), expected));
        }
        if !(1..=MAX_CHANNELS).contains(&channels) {
            let expected = format!("1 to {MAX_CHANNELS}");
            return Err(part("channels", channels.to_string(), expected));
        }
        let count = points.iter().product::<usize>() * channels;
        if count > MAX_VALUES {
            let expected = format!("at most {MAX_VALUES}");
            return Err(part("values", count.to_string(), expected));
        }
        let mut values = vec![0.0; count];
        for (i, own) in values.chunks_exact_mut(channels).enumerate() {
            let [x, y, _] = points;
            let vertex = [i % x, i / x % y, i / (x * y)];
            value(vertex, own);
            if !own.iter().all(|v| v.is_finite()) {
                let found = format!("{own:?} at vertex {vertex:?}");
                return Err(part("values", found, "finite numbers"));
            }
        }
        Ok(Self {
            points,
            channels,
            values,
        })
    }

    /// Where the values of a vertex begin.
    fn offset(&self, [x, y, z]: [usize; 3]) -> usize {
        (x + self.points[0] * (y + self.points[1] * z)) * self.channels
    }

    /// Offsets of a mode's vertices: line slowest, then the plane.
    fn offsets(&self, mode: usize) -> impl Iterator<Item = usize> + '_ {
        let ([a, b], c) = (PLANES[mode], LINES[mode]);
        let sides = [a, b, c].map(|axis| self.points[axis]);
        (0..sides[2]).flat_map(move |k| {
            (0..sides[1]).flat_map(move |j| {
                (0..sides[0]).map(move |i| {
                    let mut vertex = [0; 3];
                    (vertex[a], vertex[b], vertex[c]) = (i, j, k);
                    self.offset(vertex)
                })
            })
        })
    }

    fn norm(&self) -> f64 {
        self.values.iter().map(|v| v * v).sum::<f64>().sqrt()
    }
}

/// A term of a mode: at a vertex, the product of plane, line and channel.
#[derive(Debug, Clone, PartialEq)]
struct Term {
    line: Vec<f64>,
    plane: Vec<f64>,
    channels: Vec<f64>,
}

/// Factors of a function: the terms of each mode.
#[derive(Debug, Clone, PartialEq)]
pub struct Factors {
    modes: [Vec<Term>; 3],
    error: f64,
}

/// All products of rows with one another, a row of `side` of them.
fn gram(rows: &[f64], side: usize) -> Vec<f64> {
    let length = rows.len() / side;
    let row = |i: usize| &rows[i * length..][..length];
    (0..side * side)
        .into_par_iter()
        .map(|at| {
            // The same order both ways, hence the same sum.
            let (i, j) = (at / side, at % side);
            let pairs = row(i.min(j)).iter().zip(row(i.max(j)));
            pairs.map(|(a, b)| a * b).sum()
        })
        .collect()
}

/// The best terms of what is left of one channel, unfolded: `side` rows.
fn best(rows: &[f64], side: usize, rank: usize) -> Vec<Term> {
    let pairs = eigen(side, gram(rows, side)).into_iter();
    pairs
        .take(rank)
        .filter(|(power, _)| *power > 0.0)
        .map(|(_, line)| {
            let mut plane = vec![0.0; rows.len() / side];
            for (row, share) in rows.chunks_exact(plane.len()).zip(&line) {
                for (sum, value) in plane.iter_mut().zip(row) {
                    *sum += share * value;
                }
            }
            let channels = vec![1.0];
            Term {
                line,
                plane,
                channels,
            }
        })
        .collect()
}

/// Terms of a function of one channel, and the norm of what they leave.
fn fit(function: &Dense, ranks: [usize; 3]) -> ([Vec<Term>; 3], f64) {
    let whole = function.norm();
    let mut left = function.clone();
    let mut modes = [vec![], vec![], vec![]];
    let mut error = whole;
    for _ in 0..SWEEPS {
        for (mode, terms) in modes.iter_mut().enumerate() {
            add(&mut left, mode, terms, 1.0);
            let rows: Vec<f64> = left.offsets(mode).map(|at| left.values[at]).collect();
            *terms = best(&rows, function.points[LINES[mode]], ranks[mode]);
            add(&mut left, mode, terms, -1.0);
        }
        let gained = error - left.norm();
        error -= gained;
        if error <= EXACT * whole || gained <= GAIN * error {
            break;
        }
    }
    (modes, left.norm())
}

impl Factors {
    /// Factors of at most `ranks` terms in each mode.
    ///
    /// # Errors
    /// Fewer terms in a mode than channels, or more than 1024.
    pub fn of(function: &Dense, ranks: [usize; 3]) -> Result<Self, FieldError> {
        let channels = function.channels;
        if ranks.iter().any(|r| !(channels..=1024).contains(r)) {
            let expected = format!("{channels} to 1024 terms in each mode, one a channel at least");
            return Err(part("ranks", format!("{ranks:?}"), expected));
        }
        let fitted: Vec<_> = (0..channels)
            .into_par_iter()
            .map(|c| {
                let own = Dense {
                    points: function.points,
                    channels: 1,
                    values: function.values[c..]
                        .iter()
                        .step_by(channels)
                        .copied()
                        .collect(),
                };
                fit(
                    &own,
                    ranks.map(|r| r / channels + usize::from(c < r % channels)),
                )
            })
            .collect();
        let whole = function.norm();
        let error = fitted.iter().map(|(_, e)| e * e).sum::<f64>().sqrt();
        let mut modes = [vec![], vec![], vec![]];
        for (c, (own, _)) in fitted.into_iter().enumerate() {
            for (all, mut terms) in modes.iter_mut().zip(own) {
                for term in &mut terms {
                    term.channels = vec![0.0; channels];
                    term.channels[c] = 1.0;
                }
                all.append(&mut terms);
            }
        }
        let error = if whole > 0.0 { error / whole } else { 0.0 };
        Ok(Self { modes, error })
    }

    /// Root of the mean square error over that of the function.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.error
    }
}

/// Adds `sign` times the terms of a mode.
fn add(to: &mut Dense, mode: usize, terms: &[Term], sign: f64) {
    let channels = to.channels;
    for term in terms {
        let offsets: Vec<usize> = to.offsets(mode).collect();
        let plane = term.plane.len();
        for (i, at) in offsets.into_iter().enumerate() {
            let scale = sign * term.line[i / plane] * term.plane[i % plane];
            for (value, share) in to.values[at..at + channels].iter_mut().zip(&term.channels) {
                *value += scale * share;
            }
        }
    }
}

impl Tensorf {
    /// A model of a density before its activation, one channel, and of features
    /// of appearance, which `mlp` turns into colour; `ranks` terms a mode of
    /// each. Fewer where fewer give both exactly: a component of zeros stands
    /// for them.
    ///
    /// # Errors
    /// Functions of other sizes than each other's, or parts that do not fit.
    pub fn from_dense(
        density: &Dense,
        appearance: &Dense,
        ranks: [usize; 2],
        mlp: Mlp,
        rules: Rules,
    ) -> Result<Self, FieldError> {
        if density.channels != 1 || density.points != appearance.points {
            let found = format!("{:?} x {}", density.points, density.channels);
            let expected = format!("{:?} x 1, as the appearance has", appearance.points);
            return Err(part("density", found, expected));
        }
        let made = [
            Factors::of(density, [ranks[0]; 3])?,
            Factors::of(appearance, [ranks[1]; 3])?,
        ];
        let points = density.points;
        let features = appearance.channels;
        let all = ranks[0] + ranks[1];
        let mut tables = vec![];
        for is_line in [false, true] {
            for mode in 0..3 {
                let [a, b] = PLANES[mode].map(|axis| points[axis]);
                let along = points[LINES[mode]];
                let sides = if is_line { [along, 1, 1] } else { [a, b, 1] };
                let mut values = vec![0.0; sides[0] * sides[1] * all];
                let first = [0, ranks[0]];
                for (kind, factors) in made.iter().enumerate() {
                    for (r, term) in factors.modes[mode].iter().enumerate() {
                        let own = if is_line { &term.line } else { &term.plane };
                        for (vertex, value) in own.iter().enumerate() {
                            values[vertex * all + first[kind] + r] = *value as f32;
                        }
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
        for (mode, terms) in made[1].modes.iter().enumerate() {
            for (r, term) in terms.iter().enumerate() {
                for (feature, share) in term.channels.iter().enumerate() {
                    basis[feature * products + mode * ranks[1] + r] = *share as f32;
                }
            }
        }
        let basis = Layer::new(products, basis, vec![0.0; features])?;
        Self::new(tables, [ranks[0]; 3], basis, mlp, rules)
    }
}

#[cfg(test)]
#[path = "decompose_tests.rs"]
mod tests;
