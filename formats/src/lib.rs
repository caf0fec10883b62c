//! Fixed-point formats, the configuration and the data layouts on which the
//! generator (the crates of `hdl`) and the oracle (the crates of `golden`) have to agree.
//!
//! Nothing else is shared between those two: each computes its own constants
//! and its own arithmetic, so that a mistake in one shows against the other.

pub mod compact;
pub mod config;
pub mod document;
pub mod files;
pub mod fixed;
pub mod record;
pub mod rit;
pub mod timing;
pub mod units;
