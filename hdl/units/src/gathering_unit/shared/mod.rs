//! Parts shared by several organisations of the unit.

pub(super) mod compact_entry;
pub(super) mod counter_checks;
pub(super) mod idle;
pub(super) mod ports;
pub(super) mod reducer;
pub(super) mod report;
pub(super) mod rit_output;
mod rit_progress;
pub(super) mod rit_reader;
pub(super) mod rit_shape;
pub(super) mod rit_split;
pub(super) mod rit_writer;
pub(super) mod streams;
pub(super) mod table_checks;
pub(super) mod table_halves;
pub(super) mod unit_checks;
