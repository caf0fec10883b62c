//! What the RIT buffer issues of an entry.

use potamoi_netlist::{Signal, Ty};

/// Names of the halfwords of an entry's word.
pub(crate) const HALFWORDS: [&str; 3] = ["row", "tag", "weight"];
/// Bits of a halfword.
pub(crate) const HALF: Ty = Ty::u(16);

/// What is issued of one port's entry: one row and weight, or one for each group
/// of banks.
pub(crate) struct Given {
    pub(crate) rows: Vec<Signal>,
    pub(crate) weights: Vec<Signal>,
    pub(crate) slot: Slot,
}

/// Where a slot comes from.
pub(crate) enum Slot {
    /// With every vertex, whole.
    Whole(Signal),
    /// In the tags of vertices 0 and 1.
    Tag(Signal),
}
