//! Fixed-point formats, the configuration and the data layouts that the
//! generator (the crates of `hdl`) and the oracle (the crates of `golden`) share.
//!
//! They share nothing else. Each has its own constants and its own arithmetic, so that
//! a mistake in one shows as a difference from the other.
//!
//! # Example
//!
//! A configuration lists its differences from the paper's. The error for a broken rule names the
//! field, the value and the allowed values.
//!
//! ```
//! use potamoi_formats::config::Config;
//! use potamoi_formats::fixed::Format;
//!
//! let config = Config::from_toml("vu.exp.iterations = 12", "example")?;
//! assert_eq!(config.vu.exp.input, Format::unsigned(3, 13));
//! assert_eq!(config.vu.lanes, Config::paper().vu.lanes);
//!
//! let error = Config::from_toml("gu.banks = 0", "example").unwrap_err();
//! assert!(error.to_string().contains("gu.banks"), "{error}");
//! # Ok::<(), potamoi_formats::config::ConfigError>(())
//! ```

pub mod compact;
pub mod config;
pub mod device_file;
pub mod document;
pub mod file_kinds;
pub mod files;
pub mod fixed;
pub mod nearest;
pub mod record;
pub mod rit;
pub mod timing;
pub mod units;
