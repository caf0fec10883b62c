//! How a field is rendered in the hardware's formats, and how much of it.

use super::batches::BatchSize;

/// What is done to render a field: by default everything. Less gives the same bits where nothing
/// calls for more.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct FieldWork {
    /// Codes of a direction that are kept, from the first on; the others are 0.
    pub direction_codes: usize,
    /// Tables whose vertices share rows that are gathered from, the first of them; the features of
    /// the others are 0.
    pub hashed: usize,
    /// Whether samples are left out where the field is known to be empty.
    pub void_test: bool,
}

impl FieldWork {
    /// Everything.
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

/// How to render.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FixedOptions {
    /// Whether rays stop where the field says.
    pub terminate: bool,
    /// Linear RGB behind everything, rounded to 12 fraction bits.
    pub background: [f32; 3],
    /// Pixels a side of a ray group; by default the largest whose rays are at
    /// most [`potamoi_march::GROUP_RAYS`].
    pub group_side: Option<u32>,
    /// Samples that are gathered at a time; by default as many as
    /// [`BatchSize::of`] says.
    pub batch: Option<BatchSize>,
    /// What is done of the direction and of hashed tables.
    pub work: FieldWork,
}

impl Default for FixedOptions {
    fn default() -> Self {
        Self {
            terminate: true,
            background: [0.0; 3],
            group_side: None,
            batch: None,
            work: FieldWork::ALL,
        }
    }
}
