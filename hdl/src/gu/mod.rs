//! The gathering unit. Its interface and timing: `docs/gathering-unit.md`.

mod mft;
mod reducer;
mod report;
mod rit_buffer;
mod rit_cell;
mod rit_pick;
mod rit_reader;
mod rit_shape;
mod rit_writer;
mod top;

pub use top::gathering_unit;
