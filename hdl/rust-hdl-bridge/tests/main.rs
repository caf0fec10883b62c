//! Netlists in rust-hdl designs, and kernels of rust-hdl against netlists.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod common;
mod designs;
mod kernels;
