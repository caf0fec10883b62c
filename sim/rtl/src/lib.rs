//! Simulates the generated hardware on a Verilated model or another engine, drives the streams of
//! the units, and compares the results with golden values and cycle models.
//!
//! [`RtlUnits`] replaces the reference units, so that a renderer runs on the hardware.
//! [`verify`] compares each bit and cycle of a frame. [`GatherUnit`] and [`VectorUnit`] drive a
//! single unit on any engine ([`EngineKind`]). [`GateEngine`] runs its gate-level netlist.
//!
//! # Example
//!
//! An exponential on the hardware, run by the interpreter of netlists, equals that of the
//! reference unit.
//!
//! ```
//! use potamoi_formats::config::Config;
//! use potamoi_formats::units::{OpCode, VectorOp};
//! use potamoi_reference::{ReferenceUnits, Units};
//! use potamoi_rtl::{EngineKind, RtlUnits};
//!
//! let config = Config::preset("small").unwrap();
//! let mut hardware = RtlUnits::on(EngineKind::Interpreter, &config);
//! // exp(-u) of u in U3.13: 0, 1 and 2.
//! let (u, unused) = ([0, 1 << 13, 2 << 13], [0; 3]);
//! let exp = VectorOp::new(OpCode::Exp);
//! let [mut found, mut expected] = [[0; 3]; 2];
//! hardware.vector(exp, &u, &unused, &mut found)?;
//! ReferenceUnits::new(&config).vector(exp, &u, &unused, &mut expected)?;
//! assert_eq!(found, expected);
//! assert!(hardware.cycles().vector > 0);
//! # Ok::<(), Box<dyn std::error::Error + Send + Sync>>(())
//! ```

mod array_mac;
mod beats;
pub mod bench;
mod compare;
mod engine;
mod foreign;
mod gate_engine;
mod gather;
mod gather_check;
mod gather_drive;
mod icarus;
mod mismatch;
mod model;
mod port_trace;
mod post_failure_window;
mod runner;
mod splat_beats;
mod splats;
mod units;
mod vector;
mod vector_check;
mod vector_drive;
pub mod verify;
mod wave_dump;
mod words;

pub use array_mac::WeightProducts;
pub use beats::{FeatureBeat, GatherBeats, InputBeat, feature_beats};
pub use compare::Check;
pub use engine::EngineKind;
pub use foreign::ForeignRtl;
pub use gate_engine::GateEngine;
pub use gather::{GatherRun, GatherUnit};
pub use gather_drive::GatherTotals;
pub use mismatch::Mismatch;
pub use model::{RtlError, compile, model};
pub use port_trace::{PortTrace, TraceDifference, Traced};
pub use splats::{SplatRun, SplatUnit};
pub use units::{RtlCycles, RtlUnits};
pub use vector::{VectorRun, VectorUnit};
pub use vector_drive::{VectorBatch, VectorTotals};
