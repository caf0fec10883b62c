//! From the banks of the RIT buffer to the issue.

use super::Pipeline;

/// A register stage behind the banks of the RIT buffer. What it holds is a vertex of M entries, or
/// of M whole cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RitStage {
    /// Q: what the banks have read.
    Banks,
    /// E: the entries, picked from the row.
    Entry,
    /// G: products of the weights along y, of compact entries.
    ProductY,
    /// F: parts of the weights after y, of compact entries.
    PartY,
    /// H: products of the weights along x, of compact entries.
    ProductX,
    /// P: id, weight and slot, which are issued.
    Issue,
}

impl RitStage {
    /// The letter by which `docs/reference/gathering-unit.md` calls it.
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
    /// Of `compact` entries, or of those that bring their weights.
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
