//! The judges.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A judge, in the order in which they are asked.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Judge {
    /// The standalone bench.
    Bench,
    /// The miter of the mutant's module, from any state.
    Miter,
    /// The miter of the unit, from all states that the proofs allow.
    UnitMiter,
    /// The proofs of the checks.
    Proofs,
    /// The miter of the mutant's module, from all registers at 0.
    MiterFromZero,
    /// All operands of a pipelined exponential.
    Operands,
    /// The verification against the golden models.
    Verify,
}

impl Judge {
    /// Its name.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bench => "bench",
            Self::Miter => "miter",
            Self::UnitMiter => "unit-miter",
            Self::Proofs => "proofs",
            Self::MiterFromZero => "miter-from-zero",
            Self::Operands => "operands",
            Self::Verify => "verify",
        }
    }
}
