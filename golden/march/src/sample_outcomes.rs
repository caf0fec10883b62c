//! What gathered samples change in a picture.

use schemars::JsonSchema;
use serde::Serialize;

/// Gathered samples by what they change in the picture; each counts once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, JsonSchema)]
pub struct SampleOutcomes {
    /// Samples with a weight: their colour is computed and added.
    pub composited: u64,
    /// Samples of alpha 0, which change neither transmittance nor colour.
    pub transparent: u64,
    /// Samples of an alpha above 0 that leave the transmittance at its code, or whose weight the head
    /// leaves out.
    pub without_weight: u64,
    /// Samples behind the one that ended their ray, gathered in the same batch.
    pub behind: u64,
}

impl std::ops::Add for SampleOutcomes {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            composited: self.composited + other.composited,
            transparent: self.transparent + other.transparent,
            without_weight: self.without_weight + other.without_weight,
            behind: self.behind + other.behind,
        }
    }
}

impl SampleOutcomes {
    /// All samples whose features were gathered.
    #[must_use]
    pub const fn total(&self) -> u64 {
        self.composited + self.transparent + self.without_weight + self.behind
    }
}
