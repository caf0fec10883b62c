//! Which degrees of spherical harmonics anything depends on.

use crate::splats::sh;

/// Degrees of spherical harmonics that are stored, and what is not 0 of each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bands {
    /// The highest degree that there are coefficients for.
    pub stored: usize,
    /// What holds them: Gaussians, vertices, or a perceptron's neurons.
    pub holders: u64,
    /// Of each degree, holders with a coefficient that is not 0.
    pub used: [u64; sh::MAX_DEGREE + 1],
}

impl Bands {
    /// Those of holders whose coefficients of each degree are not all 0 where `is_used` says so.
    pub(crate) fn of(
        stored: usize,
        holders: impl Iterator<Item = [bool; sh::MAX_DEGREE + 1]>,
    ) -> Self {
        let mut bands = Self {
            stored,
            holders: 0,
            used: [0; sh::MAX_DEGREE + 1],
        };
        for own in holders {
            bands.holders += 1;
            for (sum, is_used) in bands.used.iter_mut().zip(own) {
                *sum += u64::from(is_used);
            }
        }
        bands
    }

    /// The highest degree of which a coefficient is not 0.
    #[must_use]
    pub fn highest(&self) -> usize {
        self.used.iter().rposition(|n| *n > 0).unwrap_or(0)
    }

    /// Holders with a coefficient of a degree or of one above it.
    #[must_use]
    pub fn from(&self, degree: usize) -> u64 {
        self.used.iter().skip(degree).copied().max().unwrap_or(0)
    }
}

/// Whether coefficients of each degree are there that are not 0, of one after another of a
/// list that begins with that of degree 0; each may have several numbers.
pub(crate) fn used<'a>(
    coefficients: impl Iterator<Item = &'a [f32]>,
) -> [bool; sh::MAX_DEGREE + 1] {
    let mut used = [false; sh::MAX_DEGREE + 1];
    for (number, values) in coefficients.enumerate() {
        if values.iter().any(|v| *v != 0.0)
            && let Some(own) = used.get_mut(number.isqrt())
        {
            *own = true;
        }
    }
    used
}
