//! The gathering unit. Its interface and timing: `docs/reference/gathering-unit.md`.

mod channel_major;
mod feature_major;
mod parity;
mod rit_buffer;
mod shared;

use std::sync::Arc;

use potamoi_formats::config::{Config, Organisation};
use potamoi_netlist::{IrErrors, Module};

/// Builds the gathering unit for a configuration, in its organisation.
///
/// # Errors
/// The netlist's own checks; none for a configuration that keeps its rules.
pub fn gathering_unit(config: &Config) -> Result<Arc<Module>, IrErrors> {
    match config.organisation().0 {
        Organisation::Auto | Organisation::ChannelMajor | Organisation::Parity => {
            channel_major::channel_major(config)
        }
        Organisation::FeatureMajor => feature_major::feature_major(config),
    }
}
