//! Potamoi's hardware units as netlists.
//!
//! [`gathering_unit`], [`vector_unit`] and [`splat_unit`] each build a module from a configuration.
//! Every size, width and stage comes from the configuration. [`array_mac`] is of no configuration: it stands for the
//! array around the units in synthesis.
//!
//! ```
//! use potamoi_formats::config::Config;
//!
//! let config = Config::default();
//! let unit = potamoi_units::gathering_unit::gathering_unit(&config)?;
//! assert!(unit.ports().iter().any(|port| port.name == "m_axis_feat_tdata"));
//! # Ok::<(), potamoi_netlist::IrErrors>(())
//! ```

pub mod array_mac;
mod circuits;
mod data_checks;
pub mod exponential;
mod fifo;
pub mod gathering_unit;
mod memory;
pub mod memory_list;
pub mod splat_unit;
mod stream_checks;
pub mod vector_unit;

use std::sync::Arc;

use potamoi_formats::config::Config;
use potamoi_netlist::{IrErrors, Module};

/// The units of a configuration.
///
/// # Errors
/// The netlists' own checks; none for a configuration that keeps its rules.
pub fn units(config: &Config) -> Result<Vec<Arc<Module>>, IrErrors> {
    let mut all = vec![
        gathering_unit::gathering_unit(config)?,
        vector_unit::vector_unit(config)?,
    ];
    if let Some(su) = &config.su {
        all.push(splat_unit::splat_unit(config, su)?);
    }
    Ok(all)
}
