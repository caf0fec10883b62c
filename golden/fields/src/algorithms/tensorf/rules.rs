//! What a TensoRF model says besides its numbers.

use glam::DVec3;

/// The most rounds of sines and cosines.
pub(super) const MAX_FREQUENCIES: usize = 16;

/// What makes a density of a sum of products.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum Activation {
    /// `ln(1 + exp(x + shift))`.
    Softplus,
    /// `max(x, 0)`, without the shift.
    Relu,
}

/// What a model says besides its numbers.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Rules {
    /// Corners of the box on whose faces the outer vertices lie.
    pub bounds: [DVec3; 2],
    /// Of densities.
    pub activation: Activation,
    /// Added before softplus.
    pub density_shift: f64,
    /// What the world's unit is in the unit of densities.
    pub distance_scale: f64,
    /// Mean voxel edges from sample to sample.
    pub step_ratio: f64,
    /// Samples of at most this weight give no colour.
    pub weight_threshold: f64,
    /// Samples start this far along their ray.
    pub near: f64,
    /// Rounds of sines and cosines of the features, by the factor 2.
    pub feature_frequencies: usize,
    /// Rounds of sines and cosines of the direction.
    pub view_frequencies: usize,
}

impl Rules {
    /// The authors' defaults for a box: softplus with shift -10, distance scale
    /// 25, step ratio 0.5, threshold 1e-4, two frequencies of both.
    #[must_use]
    pub fn new(bounds: [DVec3; 2]) -> Self {
        Self {
            bounds,
            activation: Activation::Softplus,
            density_shift: -10.0,
            distance_scale: 25.0,
            step_ratio: 0.5,
            weight_threshold: 1e-4,
            near: 0.0,
            feature_frequencies: 2,
            view_frequencies: 2,
        }
    }

    /// What is out of range, if anything is: field, value, expectation.
    pub(super) fn problem(&self) -> Option<(&'static str, String, &'static str)> {
        let size = self.bounds[1] - self.bounds[0];
        let corners = self.bounds.iter().all(|c| c.is_finite());
        let rounds = 0..=MAX_FREQUENCIES;
        let checks = [
            (
                "aabb",
                format!("{} to {}", self.bounds[0], self.bounds[1]),
                corners && size.cmpgt(DVec3::splat(1e-6)).all(),
                "two corners, the second above the first",
            ),
            (
                "density_shift",
                self.density_shift.to_string(),
                self.density_shift.is_finite(),
                "a finite number",
            ),
            (
                "distance_scale",
                self.distance_scale.to_string(),
                self.distance_scale > 0.0 && self.distance_scale.is_finite(),
                "a number above 0",
            ),
            (
                "step_ratio",
                self.step_ratio.to_string(),
                (1e-3..=1e3).contains(&self.step_ratio),
                "0.001 to 1000 voxel edges",
            ),
            (
                "rayMarch_weight_thres",
                self.weight_threshold.to_string(),
                (0.0..1.0).contains(&self.weight_threshold),
                "0 and up, below 1",
            ),
            (
                "near_far",
                self.near.to_string(),
                self.near >= 0.0 && self.near.is_finite(),
                "distances of 0 and up",
            ),
            (
                "fea_pe",
                self.feature_frequencies.to_string(),
                rounds.contains(&self.feature_frequencies),
                "0 to 16 frequencies",
            ),
            (
                "view_pe",
                self.view_frequencies.to_string(),
                rounds.contains(&self.view_frequencies),
                "0 to 16 frequencies",
            ),
        ];
        let wrong = checks.into_iter().find(|(_, _, right, _)| !right);
        wrong.map(|(field, value, _, expected)| (field, value, expected))
    }

    /// Inputs of the perceptron for so many features.
    pub(super) fn inputs(&self, features: usize) -> usize {
        features * (1 + 2 * self.feature_frequencies) + 3 * (1 + 2 * self.view_frequencies)
    }
}
