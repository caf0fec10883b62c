//! Potamoi's hardware units as netlists, and the Verilog of a configuration.
//!
//! [`gathering_unit`] and [`vector_unit`] each build a module from a configuration; [`emit`] prints
//! both, and [`npu`] joins them with registers for an SoC. Every size, width and stage comes from the configuration. [`array_mac`] is of no
//! configuration: it stands for the array around the units in synthesis.
//!
//! ```
//! use potamoi_formats::config::Config;
//!
//! let config = Config::default();
//! let unit = potamoi_units::gathering_unit::gathering_unit(&config)?;
//! assert!(unit.ports().iter().any(|port| port.name == "m_axis_feat_tdata"));
//! let files = potamoi_units::emit::emit(&config, "", "potamoi emit")?;
//! assert!(files.keys().any(|path| path.ends_with("reducer.v")));
//! # Ok::<(), potamoi_netlist::IrErrors>(())
//! ```

pub mod array_mac;
mod circuits;
mod data_checks;
pub mod emit;
pub mod exponential;
mod fifo;
pub mod gathering_unit;
mod memory;
pub mod memory_list;
pub mod npu;
pub mod package;
mod stream_checks;
pub mod vector_unit;
