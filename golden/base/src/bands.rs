//! Which degrees of spherical harmonics anything depends on.

use crate::sh;

/// Degrees of spherical harmonics that are stored, and what is not 0 of each.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Bands {
    /// The highest degree that there are coefficients for.
    pub stored: usize,
    /// What holds them: Gaussians, vertices, or a perceptron's neurons.
    pub holders: u64,
    /// Of each degree, holders with a coefficient that is not 0 of it or of one above it.
    from: [u64; sh::MAX_DEGREE + 1],
}

impl Bands {
    /// Those of holders whose coefficients of each degree are not all 0 where `is_used` says so.
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

    /// The highest degree of which a coefficient is not 0.
    #[must_use]
    pub fn highest(&self) -> usize {
        self.from.iter().rposition(|n| *n > 0).unwrap_or(0)
    }

    /// Holders with a coefficient of a degree or of one above it.
    #[must_use]
    pub fn from(&self, degree: usize) -> u64 {
        self.from.get(degree).copied().unwrap_or(0)
    }
}

/// Whether coefficients of each degree are there that are not 0, of one after another of a
/// list that begins with that of degree 0; each may have several numbers.
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
