//! Work of the units while a frame is shaded and composited.

use std::collections::BTreeMap;

use potamoi_formats::units::OpCode;

/// Counts of what the vector unit and the MAC array were given.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Work {
    pub(crate) elements: BTreeMap<OpCode, u64>,
    /// Products of the MAC array.
    pub(crate) products: u64,
    /// Sums of the MAC array that were held at an end of their format.
    pub(crate) held: u64,
    /// Sines and cosines of features.
    pub(crate) waves: u64,
    /// Samples that added to a pixel.
    pub(crate) composited: u64,
    pub(crate) stopped: u64,
}
