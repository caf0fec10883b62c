//! Commands and clocks of a memory.

/// Counts of commands, and clocks.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Clocks until the last burst ended, on the slowest channel.
    pub clocks: u64,
    /// Clocks with an open row, summed over ranks.
    pub active_clocks: u64,
    /// Bursts read.
    pub reads: u64,
    /// Bursts written.
    pub writes: u64,
    /// Rows opened.
    pub activates: u64,
    /// Refreshes of all banks of a rank.
    pub refreshes: u64,
}
