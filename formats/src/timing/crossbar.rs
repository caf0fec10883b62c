//! Pipeline from a channel's last round to the offer of its results, in the feature-major
//! organisation.

use super::Pipeline;

/// A pipeline stage after a round.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CrossbarStage {
    /// D: words read by the banks.
    BankWords,
    /// X: each lane's word from its bank.
    Crossed,
    /// S: the reducers' sums.
    Sum,
    /// First entry of the result FIFO.
    Fifo,
}

impl CrossbarStage {
    /// Letter of the stage; `None` for the FIFO.
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
    /// The pipeline, equal for all configurations.
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
