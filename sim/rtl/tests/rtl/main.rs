//! The generated units, run: against golden values in every bit and cycle models in every cycle.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

mod bench_mutants;
mod cells;
mod cycle_budget;
mod every_form;
mod every_operation;
mod exponential_alone;
mod exponentials;
mod faults;
mod feature_major;
mod foreign;
mod four_engines;
mod gather_cells;
mod gather_common;
mod gather_unit;
mod logistic;
mod narrow_lanes;
mod npu;
mod readmemh;
mod scenes_common;
mod splat_scenes;
mod splat_unit;
mod streams;
mod vector_unit;
mod verify;
