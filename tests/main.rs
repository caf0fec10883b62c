//! The program from end to end, the documents, and the checked-in Verilog: one binary, since each
//! is linked with the whole workspace. What keeps the architecture is a binary of its own,
//! `structure`.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod bad_input;
mod cases;
mod characterise;
mod common;
mod cost;
mod dask;
mod docs;
mod effects;
mod exponential;
mod hard_cases;
mod layouts;
mod lean_fields;
mod machine;
mod machines;
mod macros;
mod model;
mod narrow;
mod quality;
mod render;
mod report;
mod rtl_out;
mod rtl_tools;
mod schemas;
mod splat_unit;
mod synth;
mod verify;
mod warp;
