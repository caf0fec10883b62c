//! Error bounds of the vector unit's results.

use potamoi_formats::config::ExpConfig;

use super::logistic::{Logistic, logistic_budget};
use super::widths::budget;

/// Upper bounds of the absolute error, in units of the last place; infinite where no bound is
/// known.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct VectorBounds {
    /// Of `exp(-u)`, including the saturation of 1 to the largest code.
    pub exp: f64,
    /// Of `1 - exp(-s)`, including saturation and, where it is known, the rounding of s to the
    /// constants' bits.
    pub one_minus_exp: f64,
    /// Of `1 / (1 + exp(-x))`, before a result of 1 saturates.
    pub sigmoid: f64,
    /// Of `ln(1 + exp(x))`.
    pub softplus: f64,
}

impl VectorBounds {
    /// Bounds by the formulas [`budget`] and [`logistic_budget`].
    #[must_use]
    pub fn by_formula(config: &ExpConfig) -> Self {
        let logistic = |of| match config.form.offers().logistic {
            true => logistic_budget(of, config),
            false => f64::INFINITY,
        };
        Self {
            sigmoid: logistic(Logistic::Sigmoid),
            softplus: logistic(Logistic::Softplus),
            ..Self::of_powers(budget(config), budget(config))
        }
    }

    /// Bounds of the powers alone, from errors before a power of 1 saturates.
    #[must_use]
    pub const fn of_powers(exp: f64, one_minus_exp: f64) -> Self {
        Self {
            exp: exp.max(1.0),
            one_minus_exp: one_minus_exp.max(1.0),
            sigmoid: f64::INFINITY,
            softplus: f64::INFINITY,
        }
    }

    /// The lesser of each pair of bounds.
    #[must_use]
    pub const fn and(self, other: Self) -> Self {
        Self {
            exp: self.exp.min(other.exp),
            one_minus_exp: self.one_minus_exp.min(other.one_minus_exp),
            sigmoid: self.sigmoid.min(other.sigmoid),
            softplus: self.softplus.min(other.softplus),
        }
    }
}
