//! The system around the units.

use serde::Serialize;

/// The system around the units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Surroundings {
    /// Whether full frames are rendered elsewhere.
    pub is_remote: bool,
}
