//! Parts of the parity organisation: all eight vertices of a cell are read in a cycle, each from
//! the group of banks of its parities. See `docs/explanation/organisations.md`.
//!
//! The rest is the channel-major unit.

pub(super) mod block;
pub(super) mod cell_reducer;
pub(super) mod compact_cell;
pub(super) mod whole_entry;
