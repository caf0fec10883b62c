//! Where the MFT takes a row.

use potamoi_netlist::Signal;

/// Where a row is written, and which halves are written and read.
pub(super) struct Place {
    pub(super) halves: [Signal; 2],
    pub(super) write: Signal,
    /// The row, of those of a half.
    pub(super) row: Signal,
}
