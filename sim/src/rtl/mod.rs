//! Runs the generated hardware: netlist to Verilog to a Verilated model, and
//! the streams of the units on its ports.

mod gather;
mod model;
mod stall;
mod stream;
mod vector;

pub use gather::{GatherRun, GatherUnit};
pub use model::{RtlError, compile};
pub use stall::Stalls;
pub use stream::{FeatureBeat, GatherStreams, StreamError};
pub use vector::{VectorRun, VectorUnit};
