//! Models of Verilog: built, kept, refused and driven.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod building;
mod models;
