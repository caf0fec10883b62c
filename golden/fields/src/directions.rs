//! What of a field depends on the direction it is seen from.

use super::Mlp;
use potamoi_base::bands::Bands;

/// How colours depend on the direction.
#[derive(Debug, Clone, PartialEq)]
pub enum Directions<'a> {
    /// Not at all.
    None,
    /// By spherical harmonics, whose coefficients are features.
    Harmonics(Bands),
    /// By a perceptron.
    Perceptron {
        /// It.
        mlp: &'a Mlp,
        /// Which of its inputs are the direction's.
        inputs: Vec<usize>,
        /// Whether these are spherical harmonics, from degree 0 on.
        are_harmonics: bool,
    },
}

impl Mlp {
    /// Whether a weight of each of some inputs is not 0.
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

    /// Weights of some inputs, and how many of them are not 0.
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
