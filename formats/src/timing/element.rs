//! Pipeline of an element-wise operation, from its operands to the result stage.

use super::Pipeline;

/// A register stage of an element-wise operation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ElementStage {
    /// Two addends whose sum is the exact result.
    Addends,
    /// The exact result.
    Exact,
    /// The result without the bits that the shift drops. Its rounding is of the result stage.
    Shifted,
}

impl Pipeline<ElementStage> {
    /// The pipeline; with the register stages between, if the unit is `registered`.
    #[must_use]
    pub fn element_wise(registered: bool) -> Self {
        Self::built([
            (ElementStage::Addends, registered),
            (ElementStage::Exact, true),
            (ElementStage::Shifted, registered),
        ])
    }
}
