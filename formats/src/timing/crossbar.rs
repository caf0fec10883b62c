//! From the last round of a channel to the offer of its results, of the feature-major
//! organisation.

use super::Pipeline;

/// A register stage behind a round.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrossbarStage {
    /// D: the banks have read their words.
    BankWords,
    /// X: each lane has the word of its bank.
    Crossed,
    /// S: the reducers' sums.
    Sum,
    /// The FIFO of results: its first place.
    Fifo,
}

impl CrossbarStage {
    /// The letter that stands for it; none for the FIFO.
    #[must_use]
    pub const fn letter(self) -> Option<char> {
        match self {
            Self::BankWords => Some('D'),
            Self::Crossed => Some('X'),
            Self::Sum => Some('S'),
            Self::Fifo => None,
        }
    }
}

impl Pipeline<CrossbarStage> {
    /// Of every configuration.
    #[must_use]
    pub fn crossbar() -> Self {
        Self::new([
            CrossbarStage::BankWords,
            CrossbarStage::Crossed,
            CrossbarStage::Sum,
            CrossbarStage::Fifo,
        ])
    }
}
