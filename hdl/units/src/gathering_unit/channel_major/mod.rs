//! The channel-major organisation: bank `b` holds channel `b` of every row, so that M rows are read
//! in a cycle without bank conflicts. The parity organisation is the same unit with a cell's eight
//! vertices instead of one.

mod checks;
mod inputs;
mod issue;
mod mft;
mod product_stages;
mod reducers;
mod row_position;
mod shared_rows;
mod split_banks;
mod stage_one;
mod top;

pub(super) use top::channel_major;
