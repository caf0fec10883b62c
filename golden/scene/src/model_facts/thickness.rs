//! Upper bounds of a ray's absorption.

/// Upper bounds along any ray of any camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thickness {
    /// Optical depth along one ray; infinite if there is no bound.
    pub depth: f64,
    /// Number of samples or Gaussians along the ray.
    pub samples: f64,
    /// Early-termination threshold (transmittance).
    pub stop: f64,
}

/// Relative excess of a depth rounded to the coarsest formats.
const COARSE: f64 = 1.01;

impl Thickness {
    /// No bounds, for models about which nothing is known.
    #[must_use]
    pub const fn unknown(stop: f64) -> Self {
        Self {
            depth: f64::INFINITY,
            samples: f64::INFINITY,
            stop,
        }
    }

    /// Lower bound of the final transmittance, in floating point.
    #[must_use]
    pub fn least_left(&self) -> f64 {
        (-self.depth).exp()
    }

    /// Whether a ray can terminate early, if roundings reduce the transmittance by `lost` a
    /// sample.
    #[must_use]
    pub fn can_stop(&self, lost: f64) -> bool {
        let left = (-COARSE * self.depth).exp() - lost * self.samples;
        // Not a number is not at least another.
        !matches!(left.partial_cmp(&(2.0 * self.stop)), Some(order) if order.is_ge())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A depth may be rounded up by a hundredth, so the transmittance at the limit of thinness
    /// counts as less.
    #[test]
    fn a_depth_counts_as_coarsely_as_it_may_be_coded() {
        let of = |left: f64| Thickness {
            depth: -left.ln(),
            samples: 0.0,
            stop: 1e-3,
        };
        // 2e-3 to the power of 1 / 1.01 is 2.127e-3.
        assert!(of(2.12e-3).can_stop(0.0));
        assert!(!of(2.13e-3).can_stop(0.0));
    }

    /// No ray stops if the transmittance, less the loss by rounding, is at least twice the
    /// threshold; without bounds any ray may.
    #[test]
    fn rays_stop_where_too_little_may_be_left() {
        let of = |left: f64, samples: f64| Thickness {
            depth: -left.ln() / COARSE,
            samples,
            stop: 1e-3,
        };
        assert!(of(1.9e-3, 0.0).can_stop(3e-5));
        assert!(!of(2.1e-3, 0.0).can_stop(3e-5));
        // 20 samples take 6e-4.
        assert!(of(2.5e-3, 20.0).can_stop(3e-5));
        assert!(!of(2.7e-3, 20.0).can_stop(3e-5));
        assert!(of(2.7e-3, 20.0).can_stop(4e-5));
        assert!(Thickness::unknown(0.0).can_stop(3e-5));
    }
}
