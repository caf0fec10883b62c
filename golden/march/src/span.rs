//! The samples of one ray in a batch.

/// Consecutive entries of one ray in a batch of tasks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    /// The slot of the ray in its group.
    pub ray: u32,
    /// Its first entry.
    pub start: u32,
    /// Number of entries.
    pub len: u32,
}
