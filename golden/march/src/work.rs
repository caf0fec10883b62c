//! Work of the units for shading and compositing a frame.

use std::collections::BTreeMap;

use potamoi_formats::units::OpCode;

use crate::sample_outcomes::SampleOutcomes;

/// Counts of the requests to the vector unit and the MAC array.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Work {
    pub(crate) elements: BTreeMap<OpCode, u64>,
    /// Operations of the MAC array.
    pub(crate) products: u64,
    /// Sums of the MAC array that saturated.
    pub(crate) held: u64,
    /// Sines and cosines of encoded features.
    pub(crate) waves: u64,
    pub(crate) outcomes: SampleOutcomes,
    pub(crate) stopped: u64,
}
