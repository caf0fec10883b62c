//! Why power cannot be estimated.

use potamoi_gates::Gate;

use crate::SynthError;

/// Why there is no estimate.
#[derive(Debug)]
pub(super) enum Unavailable {
    /// The library lacks data.
    Absent(String),
    /// An error occurred.
    Wrong(SynthError),
}

impl Unavailable {
    pub(super) fn of(gate: &Gate, what: &str) -> Self {
        Self::Absent(format!("the library's cell {} has {what}", gate.name))
    }
}

impl From<SynthError> for Unavailable {
    fn from(error: SynthError) -> Self {
        Self::Wrong(error)
    }
}
