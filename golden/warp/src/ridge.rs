//! Bayesian ridge regression (MacKay 1992; Tipping 2001): a linear fit that estimates noise and
//! shrinkage from the data.

use nalgebra::{DMatrix, DVector};

/// Priors and stopping criteria; the defaults are those of scikit-learn's `BayesianRidge`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BayesianRidge {
    /// Shape of the prior of the noise's precision.
    pub alpha_shape: f64,
    /// Rate of the prior of the noise's precision.
    pub alpha_rate: f64,
    /// Shape of the prior of the coefficients' precision.
    pub lambda_shape: f64,
    /// Rate of the prior of the coefficients' precision.
    pub lambda_rate: f64,
    /// The iteration stops once the sum of all coefficients' changes is below this.
    pub tolerance: f64,
    /// Maximum number of iterations.
    pub most_steps: usize,
}

impl Default for BayesianRidge {
    fn default() -> Self {
        Self {
            alpha_shape: 1e-6,
            alpha_rate: 1e-6,
            lambda_shape: 1e-6,
            lambda_rate: 1e-6,
            tolerance: 1e-3,
            most_steps: 300,
        }
    }
}

/// A fitted linear function.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// Change of the value with each feature.
    pub coefficients: Vec<f64>,
    /// The value where all features are 0.
    pub intercept: f64,
    /// Precision of the noise.
    pub alpha: f64,
    /// Precision of the coefficients.
    pub lambda: f64,
}

impl Fit {
    /// The value for given features.
    #[must_use]
    pub fn at(&self, features: &[f64]) -> f64 {
        let terms = self.coefficients.iter().zip(features);
        self.intercept + terms.map(|(c, f)| c * f).sum::<f64>()
    }
}

impl BayesianRidge {
    /// Fits values to rows of features of equal length; `None` without rows, or if rows differ in
    /// length or a number is not finite.
    #[must_use]
    pub fn fit(&self, rows: &[Vec<f64>], values: &[f64]) -> Option<Fit> {
        let features = rows.first()?.len();
        let finite = rows.iter().flatten().chain(values).all(|v| v.is_finite());
        if rows.len() != values.len() || rows.iter().any(|r| r.len() != features) || !finite {
            return None;
        }
        let n = rows.len() as f64;
        let centre = |f: usize| rows.iter().map(|r| r[f]).sum::<f64>() / n;
        let centres: Vec<f64> = (0..features).map(centre).collect();
        let mean = values.iter().sum::<f64>() / n;
        let x = DMatrix::from_fn(rows.len(), features, |r, c| rows[r][c] - centres[c]);
        let y = DVector::from_iterator(rows.len(), values.iter().map(|v| v - mean));

        let svd = x.clone().svd(true, true);
        let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else {
            return None;
        };
        let squares: Vec<f64> = svd.singular_values.iter().map(|s| s * s).collect();
        // U^T y times each singular value: X^T y by its right singular vectors.
        let along = u.transpose() * &y;
        let coefficients = |alpha: f64, lambda: f64| {
            let ratio = lambda / alpha;
            let parts = squares.iter().zip(&svd.singular_values).zip(&along);
            let parts = parts.map(|((square, s), a)| s * a / (square + ratio));
            v_t.transpose() * DVector::from_iterator(squares.len(), parts)
        };

        let mut alpha = 1.0 / (y.norm_squared() / n + f64::EPSILON);
        let mut lambda = 1.0;
        let mut last: Option<DVector<f64>> = None;
        for _ in 0..self.most_steps {
            let found = coefficients(alpha, lambda);
            let residual = (&y - &x * &found).norm_squared();
            let terms = squares.iter().map(|s| alpha * s / (lambda + alpha * s));
            let gamma: f64 = terms.sum();
            lambda =
                (gamma + 2.0 * self.lambda_shape) / (found.norm_squared() + 2.0 * self.lambda_rate);
            alpha = (n - gamma + 2.0 * self.alpha_shape) / (residual + 2.0 * self.alpha_rate);
            let change = last.map(|last| (&found - last).abs().sum());
            last = Some(found);
            if change.is_some_and(|change| change < self.tolerance) {
                break;
            }
        }
        let coefficients: Vec<f64> = coefficients(alpha, lambda).iter().copied().collect();
        let shift: f64 = centres.iter().zip(&coefficients).map(|(m, c)| m * c).sum();
        Some(Fit {
            intercept: mean - shift,
            coefficients,
            alpha,
            lambda,
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use proptest::prelude::*;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Case {
        x: Vec<Vec<f64>>,
        y: Vec<f64>,
        coef: Vec<f64>,
        intercept: f64,
        alpha: f64,
        lambda: f64,
    }

    /// Recorded by tools/warp-fixtures.
    const FIXTURES: &str = include_str!("../../tests/fixtures/bayesian_ridge.json");

    #[test]
    fn it_is_scikit_learns() {
        let cases: Vec<Case> = serde_json::from_str(FIXTURES).unwrap();
        assert!(cases.len() >= 40);
        for (number, case) in cases.iter().enumerate() {
            let fit = BayesianRidge::default().fit(&case.x, &case.y).unwrap();
            let close = |a: f64, b: f64, what: &str| {
                let error = (a - b).abs();
                assert!(
                    error <= 1e-9 * b.abs() + 1e-12,
                    "case {number}, {what}: {a} {b}"
                );
            };
            for (a, b) in fit.coefficients.iter().zip(&case.coef) {
                close(*a, *b, "coefficient");
            }
            close(fit.intercept, case.intercept, "intercept");
            close(fit.alpha, case.alpha, "alpha");
            close(fit.lambda, case.lambda, "lambda");
        }
    }

    #[test]
    fn what_cannot_be_fitted_is_refused() {
        let ridge = BayesianRidge::default();
        assert!(ridge.fit(&[], &[]).is_none());
        assert!(
            ridge
                .fit(&[vec![1.0], vec![1.0, 2.0]], &[1.0, 2.0])
                .is_none()
        );
        assert!(ridge.fit(&[vec![1.0]], &[f64::NAN]).is_none());
        assert!(ridge.fit(&[vec![1.0]], &[1.0, 2.0]).is_none());
    }

    proptest! {
        #[test]
        fn it_is_finite_and_never_steeper_than_least_squares(
            y in prop::collection::vec(-1e6f64..1e6, 1..9), scale in -12i32..6,
        ) {
            let y: Vec<f64> = y.iter().map(|v| v * 10f64.powi(scale)).collect();
            let x: Vec<Vec<f64>> = (0..y.len()).map(|i| vec![i as f64]).collect();
            let fit = BayesianRidge::default().fit(&x, &y).unwrap();
            let n = y.len() as f64;
            let (mx, my) = ((n - 1.0) / 2.0, y.iter().sum::<f64>() / n);
            let sums = y.iter().enumerate().fold((0.0, 0.0), |(xy, xx), (i, y)| {
                let d = i as f64 - mx;
                (xy + d * (y - my), xx + d * d)
            });
            let slope = if sums.1 > 0.0 { sums.0 / sums.1 } else { 0.0 };
            prop_assert!(fit.coefficients[0].is_finite() && fit.intercept.is_finite());
            prop_assert!(fit.coefficients[0].abs() <= slope.abs() * (1.0 + 1e-9) + 1e-300);
        }
    }
}
