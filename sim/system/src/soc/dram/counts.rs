//! What a memory did.

/// Commands that were issued, and clocks.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Clocks until the last burst was over, of the channel that took longest.
    pub clocks: u64,
    /// Clocks in which some row was open, over all channels.
    pub active_clocks: u64,
    /// Bursts read.
    pub reads: u64,
    /// Bursts written.
    pub writes: u64,
    /// Rows opened.
    pub activates: u64,
    /// Refreshes of all banks of a channel.
    pub refreshes: u64,
}
