//! Options of fixed-point rendering, and optional parts of the work.

use super::batches::BatchSize;
use potamoi_march::TRANSMITTANCE;

/// Optional parts of the work, by default all. Leaving out a part that the field does not need
/// gives the same bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FieldWork {
    /// Number of direction codes kept, from the first on; the others are 0.
    pub direction_codes: usize,
    /// Number of hashed tables gathered, from the first on; the features of the others are 0.
    pub hashed: usize,
    /// Whether samples are skipped where the field is known to be empty.
    pub void_test: bool,
}

impl FieldWork {
    /// All parts.
    pub const ALL: Self = Self {
        direction_codes: usize::MAX,
        hashed: usize::MAX,
        void_test: true,
    };
}

impl Default for FieldWork {
    fn default() -> Self {
        Self::ALL
    }
}

/// Options of the fixed-point renderer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedOptions {
    /// Whether rays terminate early, at the field's threshold.
    pub terminate: bool,
    /// Fraction bits of the transmittance carried from sample to sample, at most 20.
    pub transmittance_bits: u32,
    /// Background, linear RGB, rounded to 12 fraction bits.
    pub background: [f32; 3],
    /// Side of a ray group in pixels; by default the largest with at most
    /// [`potamoi_march::GROUP_RAYS`] rays.
    pub group_side: Option<u32>,
    /// Limits of a batch; by default those of [`BatchSize::of`], or [`BatchSize::VOLUME`] for
    /// a field in one volume.
    pub batch: Option<BatchSize>,
    /// Optional parts of the work.
    pub work: FieldWork,
}

impl Default for FixedOptions {
    fn default() -> Self {
        Self {
            terminate: true,
            transmittance_bits: TRANSMITTANCE.frac_bits(),
            background: [0.0; 3],
            group_side: None,
            batch: None,
            work: FieldWork::ALL,
        }
    }
}
