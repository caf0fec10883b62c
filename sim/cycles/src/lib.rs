//! Cycle models of the two units and of the MAC array, written from their documented rules, and
//! meters that use them to count a frame's work. Nothing here runs Verilog.
//!
//! [`gathering_unit`] and [`vector_unit`] step one clock cycle a call, and return every handshake,
//! issue and counter of that cycle. [`closed_form`] computes the same totals for each MVoxel in closed
//! form, if sources and sink are always ready. Its run time does not depend on the number of
//! entries. [`stimulus`] plans the readiness of sources and sink independently of any model, so
//! that one plan can drive a model and hardware. [`drive`] runs a plan on a model.
//!
//! [`GatherWork`] is the input of a gathering unit: golden tasks as a run of MVoxels, their beats
//! as port words ([`BeatWords`]), and the order of feature beats. Meters and drivers of hardware
//! share it. [`layouts`] counts one frame for several organisations. [`frame_meter`] and
//! [`effect_meter`] observe the units' calls while a frame is rendered. They count its batches, and
//! the cycles of each effect.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use potamoi_cycles::{GatherRun, Mvoxel, gather_cycles};
//! use potamoi_formats::config::Config;
//! use potamoi_formats::rit::Vertices;
//!
//! let config = Config::paper();
//! let mvoxels = [Mvoxel { entries: 256, rows: 125 }];
//! let run = GatherRun { vertices: Vertices::Eight, segments: 1, mvoxels: &mvoxels };
//! let cycles = gather_cycles(&config, &run)?;
//! // Two ports, eight vertices an entry, one a cycle.
//! assert_eq!(cycles.busy, 256 / 2 * 8);
//! # Ok(())
//! # }
//! ```

pub mod bank_rounds;
pub mod batch;
mod beat_words;
pub mod closed_form;
pub mod drive;
pub mod effect_meter;
pub mod exponential;
pub mod feature_major;
pub mod frame_meter;
mod gather_work;
pub mod gathering_unit;
pub mod layouts;
pub mod mac_array;
mod organisation;
mod rit_buffer;
mod row_remap;
pub mod splat_unit;
pub mod split_banks;
pub mod stimulus;
pub mod vector_unit;
pub mod work;

#[cfg(test)]
mod tests;

pub use bank_rounds::Rounds;
pub use beat_words::BeatWords;
pub use closed_form::{
    ClosedVector, GatherCycles, VectorCycles, gather_cycles, split_cycles, vector_cycles,
};
pub use drive::{CycleLog, run_gather, run_gather_watched, run_split};
pub use exponential::Exponents;
pub use feature_major::{FeatureMajorModel, LaneRun, feature_major_cycles};
pub use gather_work::{GatherWork, Group, StreamError, runs};
pub use gathering_unit::{GatherInputs, GatherModel, GatherOutputs};
pub use organisation::UnitModel;
pub use split_banks::SplitRun;
pub use stimulus::{Plan, Source, Stalls, StreamStalls, Willing};
pub use vector_unit::{VectorInputs, VectorModel, VectorOutputs};
pub use work::{GatherRun, Mvoxel, WorkError};
