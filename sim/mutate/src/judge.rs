//! The judges.

use serde::Serialize;

/// A judge.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Judge {
    /// The standalone bench.
    Bench,
    /// The miter of the mutant's module.
    Miter,
    /// The verification against the golden models.
    Verify,
    /// The proofs of the checks.
    Proofs,
}
