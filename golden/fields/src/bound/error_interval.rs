//! Errors with a known part.

/// The difference of a fixed-point value from the floating-point one: `known`, plus or minus
/// `most`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct ErrorInterval {
    pub(crate) known: f64,
    pub(crate) most: f64,
}

impl ErrorInterval {
    /// A difference that is known exactly.
    pub(crate) const fn exactly(known: f64) -> Self {
        Self { known, most: 0.0 }
    }

    /// A difference of at most `most` in either direction.
    pub(crate) const fn within(most: f64) -> Self {
        Self { known: 0.0, most }
    }

    /// Upper bound of the magnitude.
    #[must_use]
    pub const fn largest(self) -> f64 {
        self.known.abs() + self.most
    }

    /// The same difference after a further rounding of at most `most`.
    pub(crate) const fn rounded(self, most: f64) -> Self {
        Self {
            known: self.known,
            most: self.most + most,
        }
    }

    /// The difference of the product of two values, from those of the factors.
    pub(crate) const fn product([a, b]: [f64; 2], [of_a, of_b]: [Self; 2]) -> Self {
        Self {
            known: a * of_b.known + b * of_a.known + of_a.known * of_b.known,
            most: (a + of_a.known).abs() * of_b.most
                + (b + of_b.known).abs() * of_a.most
                + of_a.most * of_b.most,
        }
    }
}

impl std::ops::Add for ErrorInterval {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            known: self.known + other.known,
            most: self.most + other.most,
        }
    }
}
