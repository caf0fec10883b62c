//! Pipeline from the banks of the RIT buffer to the issue.

use super::Pipeline;

/// A pipeline stage after the banks of the RIT buffer. It holds a vertex of M entries, or M whole
/// cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RitStage {
    /// Q: words read by the banks.
    Banks,
    /// E: entries selected from the row.
    Entry,
    /// G: products of the weights along y, of compact entries.
    ProductY,
    /// F: partial weights after y, of compact entries.
    PartY,
    /// H: products of the weights along x, of compact entries.
    ProductX,
    /// P: id, weight and slot at the issue.
    Issue,
}

impl RitStage {
    /// Letter in `docs/reference/gathering-unit.md`.
    #[must_use]
    pub const fn letter(self) -> char {
        match self {
            Self::Banks => 'Q',
            Self::Entry => 'E',
            Self::ProductY => 'G',
            Self::PartY => 'F',
            Self::ProductX => 'H',
            Self::Issue => 'P',
        }
    }
}

impl Pipeline<RitStage> {
    /// Pipeline of `compact` entries, or of entries with their own weights.
    #[must_use]
    pub fn rit(compact: bool, pipelined: bool) -> Self {
        Self::built([
            (RitStage::Banks, true),
            (RitStage::Entry, compact || pipelined),
            (RitStage::ProductY, compact && pipelined),
            (RitStage::PartY, compact),
            (RitStage::ProductX, compact && pipelined),
            (RitStage::Issue, true),
        ])
    }
}
