//! The gathering unit. Its interface and timing: `docs/gathering-unit.md`.

mod feature_major;
mod mft;
mod ports;
mod reducer;
mod report;
mod rit_buffer;
mod rit_cell;
mod rit_pick;
mod rit_reader;
mod rit_shape;
mod rit_split;
mod rit_writer;
mod row_place;
mod split_banks;
mod streams;
mod table_halves;
mod top;

use std::sync::Arc;

use potamoi_formats::config::{Config, Organisation};

use crate::ir::{IrErrors, Module};

/// Builds the gathering unit for a configuration, in its organisation.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub fn gathering_unit(config: &Config) -> Result<Arc<Module>, IrErrors> {
    match config.organisation().0 {
        Organisation::Auto | Organisation::ChannelMajor | Organisation::Parity => {
            top::channel_major(config)
        }
        Organisation::FeatureMajor => feature_major::feature_major(config),
    }
}
