//! Runs the generated hardware: netlist to Verilog to a Verilated model (or
//! another engine), the streams of the units on its ports, and the comparison
//! with golden values and cycle models.

mod beats;
mod compare;
mod engine;
mod gate_engine;
mod gather;
mod gather_check;
mod gather_drive;
mod icarus;
mod mismatch;
mod model;
mod post_failure_window;
mod readmemh;
mod runner;
mod units;
mod vector;
mod vector_check;
mod vector_drive;
pub mod verify;
mod wave_dump;
mod words;

pub use beats::{FeatureBeat, GatherBeats, InputBeat, feature_beats};
pub use compare::Check;
pub use engine::EngineKind;
pub use gate_engine::GateEngine;
pub use gather::{GatherRun, GatherUnit};
pub use gather_drive::GatherTotals;
pub use mismatch::Mismatch;
pub use model::{RtlError, compile, model};
pub use readmemh::{MemoryFile, ReadmemhFiles, readmemh};
pub use units::{RtlCycles, RtlUnits};
pub use vector::{VectorRun, VectorUnit};
pub use vector_drive::{VectorBatch, VectorTotals};
