//! View dependence of colours.

use super::Mlp;
use potamoi_base::sh_degrees::Bands;

/// The way in which colours depend on the viewing direction.
#[derive(Debug, Clone, PartialEq)]
pub enum Directions<'a> {
    /// They do not.
    None,
    /// By spherical harmonics, whose coefficients are features.
    Harmonics {
        /// The harmonics, by degree.
        bands: Bands,
        /// Name of the owners of their coefficients, in the plural.
        holders: &'static str,
    },
    /// By a perceptron.
    Perceptron {
        /// The perceptron.
        mlp: &'a Mlp,
        /// Which of its inputs encode the direction.
        inputs: Vec<usize>,
        /// Whether these are spherical harmonics, from degree 0 on.
        are_harmonics: bool,
    },
}

impl Mlp {
    /// For each of some inputs, whether it has a weight other than 0.
    #[must_use]
    pub fn uses(&self, inputs: &[usize]) -> Vec<bool> {
        let Some(first) = self.layers().first() else {
            return vec![false; inputs.len()];
        };
        let is_used = |input: &usize| {
            let rows = first.weights().chunks_exact(first.inputs());
            let mut own = rows.filter_map(|row| row.get(*input));
            own.any(|weight| *weight != 0.0)
        };
        inputs.iter().map(is_used).collect()
    }

    /// Number of weights of some inputs, and how many of them are not 0.
    #[must_use]
    pub fn weights_of(&self, inputs: &[usize]) -> [u64; 2] {
        let Some(first) = self.layers().first() else {
            return [0; 2];
        };
        let rows = first.weights().chunks_exact(first.inputs());
        let own = rows.flat_map(|row| inputs.iter().filter_map(|i| row.get(*i)));
        own.fold([0, 0], |[all, used], weight| {
            [all + 1, used + u64::from(*weight != 0.0)]
        })
    }
}
