//! Figures at both bounds of the GPU's kernels.

use schemars::JsonSchema;
use serde::Serialize;

/// A figure with the demands of each GPU kernel overlapped wholly (`max`), and one after the other
/// (`sum`). The truth lies between; which of both is nearer is not known.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
pub struct AtBounds<T> {
    /// Demands overlap wholly: a kernel takes its largest one.
    pub max: T,
    /// Demands do not overlap: a kernel takes their sum.
    pub sum: T,
}

impl<T> AtBounds<T> {
    /// A figure of each.
    #[must_use]
    pub fn map<U>(&self, of: impl Fn(&T) -> U) -> AtBounds<U> {
        AtBounds {
            max: of(&self.max),
            sum: of(&self.sum),
        }
    }
}

impl AtBounds<f64> {
    /// Geometric mean of both: a convention, not a finding.
    #[must_use]
    pub fn mid(&self) -> f64 {
        (self.max * self.sum).sqrt()
    }

    /// The smaller.
    #[must_use]
    pub const fn low(&self) -> f64 {
        self.max.min(self.sum)
    }

    /// The larger.
    #[must_use]
    pub const fn high(&self) -> f64 {
        self.max.max(self.sum)
    }

    /// Ratio to another figure, bound by bound: both machines have the same kind of GPU.
    #[must_use]
    pub fn over(&self, other: &Self) -> Self {
        Self {
            max: self.max / other.max,
            sum: self.sum / other.sum,
        }
    }

    /// Whether a ratio says which of two is faster: both bounds lie on one side of 1.
    #[must_use]
    pub const fn decides(&self) -> bool {
        self.low() > 1.0 || self.high() < 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ratio_that_flips_decides_nothing() {
        let of = |max, sum| AtBounds { max, sum };
        assert!(of(1.2, 3.0).decides() && of(0.4, 0.9).decides());
        assert!(!of(0.9, 1.1).decides() && !of(1.1, 0.9).decides() && !of(1.0, 1.2).decides());
        assert_eq!(of(2.0, 8.0).over(&of(1.0, 2.0)), of(2.0, 4.0));
        assert_eq!((of(2.0, 8.0).mid(), of(8.0, 2.0).low()), (4.0, 2.0));
    }
}
