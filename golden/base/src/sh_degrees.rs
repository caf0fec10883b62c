//! Usage of spherical-harmonics degrees.

use crate::sh;

/// Stored degrees of spherical harmonics, and how many coefficients of each are not 0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bands {
    /// The highest stored degree.
    pub stored: usize,
    /// Number of owners of coefficients: Gaussians, vertices, or a perceptron's neurons.
    pub holders: u64,
    /// For each degree, the owners with a non-zero coefficient of at least that degree.
    from: [u64; sh::MAX_DEGREE + 1],
}

impl Bands {
    /// Counts owners. Each item states for every degree whether any of its coefficients is not 0.
    pub fn of(stored: usize, holders: impl Iterator<Item = [bool; sh::MAX_DEGREE + 1]>) -> Self {
        let mut bands = Self {
            stored,
            holders: 0,
            from: [0; sh::MAX_DEGREE + 1],
        };
        for own in holders {
            bands.holders += 1;
            let highest = own.iter().rposition(|is_used| *is_used);
            for sum in bands.from.iter_mut().take(highest.map_or(0, |h| h + 1)) {
                *sum += 1;
            }
        }
        bands
    }

    /// The highest degree with a non-zero coefficient.
    #[must_use]
    pub fn highest(&self) -> usize {
        self.from.iter().rposition(|n| *n > 0).unwrap_or(0)
    }

    /// Number of owners with a non-zero coefficient of at least `degree`.
    #[must_use]
    pub fn from(&self, degree: usize) -> u64 {
        self.from.get(degree).copied().unwrap_or(0)
    }
}

/// Whether each degree has a non-zero coefficient, for coefficients listed from degree 0 on. Each
/// coefficient may have several numbers.
pub fn used<'a>(coefficients: impl Iterator<Item = &'a [f32]>) -> [bool; sh::MAX_DEGREE + 1] {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_holder_counts_once_whichever_of_its_degrees_are_used() {
        let one = |degrees: &[usize]| std::array::from_fn(|d| degrees.contains(&d));
        let all = [one(&[1]), one(&[2]), one(&[0, 2]), one(&[0]), one(&[])];
        let bands = Bands::of(2, all.into_iter());
        assert_eq!((bands.holders, bands.highest()), (5, 2));
        assert_eq!([0, 1, 2, 3, 9].map(|d| bands.from(d)), [4, 3, 2, 0, 0]);
    }
}
