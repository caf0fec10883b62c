//! Where the samples of one ray lie in a batch.

/// Entries that one ray has in a batch of tasks.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Span {
    /// The slot of the ray in its group.
    pub ray: u32,
    /// Its first entry in the batch.
    pub start: u32,
    /// Entries, one after another.
    pub len: u32,
}
