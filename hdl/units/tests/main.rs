//! The generated units: what the rules allow, flags by hand, and ranges.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod any_configuration;
mod feature_major_flags;
mod gathering_unit_flags;
mod ranges_of_units;
mod vector_unit_flags;
