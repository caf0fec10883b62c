//! The channel-major organisation: bank `b` holds channel `b` of every row, so that M rows are
//! read in a cycle without a conflict. The parity organisation is the same unit, with a cell's
//! eight vertices in place of one.

mod mft;
mod row_place;
mod split_banks;
mod top;

pub(super) use top::channel_major;
