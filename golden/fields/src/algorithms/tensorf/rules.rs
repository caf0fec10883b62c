//! Activation, sampling and thresholds of a TensoRF model.

use glam::DVec3;

/// Maximum number of frequencies.
pub(super) const MAX_FREQUENCIES: usize = 16;

/// Activation from a sum of products to a density.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub enum Activation {
    /// `ln(1 + exp(x + shift))`.
    Softplus,
    /// `max(x, 0)`, without the shift.
    Relu,
}

/// Activation, sampling and thresholds of a model.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Rules {
    /// Corners of the box whose faces contain the outer vertices.
    pub bounds: [DVec3; 2],
    /// Activation of densities.
    pub activation: Activation,
    /// Added before softplus.
    pub density_shift: f64,
    /// World units in units of densities.
    pub distance_scale: f64,
    /// Step in mean voxel edges.
    pub step_ratio: f64,
    /// Weight threshold: the colour of samples of at most this weight is not computed.
    pub weight_threshold: f64,
    /// Distance of the first sample along its ray.
    pub near: f64,
    /// Number of frequencies in the encoding of features, powers of two.
    pub feature_frequencies: usize,
    /// Number of frequencies in the encoding of the direction.
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

    /// The first value out of range: field, value, allowed values.
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

    /// Number of inputs of the perceptron for `features` features.
    pub(super) fn inputs(&self, features: usize) -> usize {
        features * (1 + 2 * self.feature_frequencies) + 3 * (1 + 2 * self.view_frequencies)
    }
}
