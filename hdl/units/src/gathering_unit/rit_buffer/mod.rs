//! The RIT buffer and its output of each cycle: one vertex of M entries, or whole cells.

mod buffer;
mod by_index;
mod checks;
mod compact;
mod invariants;
mod reader_data;
mod vertex;

pub(super) use buffer::rit_buffer;
pub(super) use reader_data::weights;
