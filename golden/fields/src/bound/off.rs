//! Differences of which a part is known.

/// How far a value of the hardware's lies above that of floating point: `known`, give or take
/// `most`.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Off {
    pub(crate) known: f64,
    pub(crate) most: f64,
}

impl Off {
    /// Of a code whose value is known.
    pub(crate) const fn exactly(known: f64) -> Self {
        Self { known, most: 0.0 }
    }

    /// At most so far on either side.
    pub(crate) const fn within(most: f64) -> Self {
        Self { known: 0.0, most }
    }

    /// The largest difference.
    #[must_use]
    pub const fn largest(self) -> f64 {
        self.known.abs() + self.most
    }

    /// With another rounding.
    pub(crate) const fn rounded(self, most: f64) -> Self {
        Self {
            known: self.known,
            most: self.most + most,
        }
    }

    /// Of the product of two values that are off.
    pub(crate) const fn product([a, b]: [f64; 2], [of_a, of_b]: [Self; 2]) -> Self {
        Self {
            known: a * of_b.known + b * of_a.known + of_a.known * of_b.known,
            most: (a + of_a.known).abs() * of_b.most
                + (b + of_b.known).abs() * of_a.most
                + of_a.most * of_b.most,
        }
    }
}

impl std::ops::Add for Off {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            known: self.known + other.known,
            most: self.most + other.most,
        }
    }
}
