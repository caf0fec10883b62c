//! Write position of a row in the MFT.

use potamoi_netlist::{Feed, Signal};

/// Write position of a row, and the halves written and read.
pub(super) struct RowPosition {
    pub(super) halves: [Signal; 2],
    /// Whether each half is loaded.
    pub(super) loaded: Signal,
    /// The half that was read last.
    pub(super) read_last: Signal,
    pub(super) write: Signal,
    /// Index of the row within a half.
    pub(super) row: Signal,
}

impl RowPosition {
    /// Inputs that all banks share, without the write's enable and address.
    pub(super) fn of_halves(&self) -> Vec<(&'static str, Feed<'static>)> {
        let [write, read] = self.halves;
        vec![
            ("write_half", Feed::Shared(write)),
            ("read_half", Feed::Shared(read)),
            ("loaded", Feed::Shared(self.loaded)),
            ("half_of_words", Feed::Shared(self.read_last)),
        ]
    }
}
