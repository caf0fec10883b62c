//! Write position of a row in the MFT.

use potamoi_netlist::Signal;

/// Write position of a row, and the halves written and read.
pub(super) struct RowPosition {
    pub(super) halves: [Signal; 2],
    pub(super) write: Signal,
    /// Index of the row within a half.
    pub(super) row: Signal,
}
