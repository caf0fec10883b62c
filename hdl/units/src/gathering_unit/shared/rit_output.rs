//! Output of the RIT buffer for an entry.

use potamoi_netlist::{Signal, Ty};

/// Names of the halfwords of an entry's word.
pub(crate) const HALFWORDS: [&str; 3] = ["row", "tag", "weight"];
/// Type of a halfword.
pub(crate) const HALF: Ty = Ty::u(16);

/// Issued data of one port's entry: one row and weight, or one for each group of banks.
pub(crate) struct RitOutput {
    pub(crate) rows: Vec<Signal>,
    pub(crate) weights: Vec<Signal>,
    pub(crate) slot: Slot,
}

/// Source of a slot.
pub(crate) enum Slot {
    /// Complete with every vertex.
    Whole(Signal),
    /// Split over the tags of vertices 0 and 1.
    Tag(Signal),
}
