//! How much light a ray can lose at most.

/// A bound of what a ray passes, whatever the camera.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Thickness {
    /// Optical depth of everything along one ray; infinite where nothing bounds it.
    pub depth: f64,
    /// Samples or Gaussians along it.
    pub samples: f64,
    /// A ray stops where less than this is left of it.
    pub stop: f64,
}

/// Depths that are rounded to the coarsest formats.
const COARSE: f64 = 1.01;
/// Units of the last place by which an opacity is off, at most.
const OPACITY_ULPS: f64 = 2.0;
/// What rounding takes of a transmittance in U1.20 a sample.
const TRANSMITTANCE_ULP: f64 = 1.0 / (1 << 20) as f64;

impl Thickness {
    /// Of a model of which nothing is known.
    #[must_use]
    pub const fn unknown(stop: f64) -> Self {
        Self {
            depth: f64::INFINITY,
            samples: f64::INFINITY,
            stop,
        }
    }

    /// The least that is left of a ray, in floating point.
    #[must_use]
    pub fn least_left(&self) -> f64 {
        (-self.depth).exp()
    }

    /// Whether a ray can stop early where opacities have so many fraction bits.
    #[must_use]
    pub fn can_stop(&self, opacity_bits: u32) -> bool {
        let lost = OPACITY_ULPS * 2f64.powi(-(opacity_bits as i32)) + TRANSMITTANCE_ULP;
        let left = (-COARSE * self.depth).exp() - lost * self.samples;
        // Not a number is not at least another.
        !matches!(left.partial_cmp(&(2.0 * self.stop)), Some(order) if order.is_ge())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// From twice the limit on, what roundings take counted in, no ray stops; where nothing is
    /// known one may.
    #[test]
    fn rays_stop_where_too_little_may_be_left() {
        let of = |left: f64, samples: f64| Thickness {
            depth: -left.ln() / COARSE,
            samples,
            stop: 1e-3,
        };
        assert!(of(1.9e-3, 0.0).can_stop(16));
        assert!(!of(2.1e-3, 0.0).can_stop(16));
        // 20 samples take 20 (2 x 2^-16 + 2^-20), 6.3e-4.
        assert!(of(2.5e-3, 20.0).can_stop(16));
        assert!(!of(2.7e-3, 20.0).can_stop(16));
        assert!(of(2.7e-3, 20.0).can_stop(12));
        assert!(Thickness::unknown(0.0).can_stop(16));
    }
}
