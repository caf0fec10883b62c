//! The exponential alone: every input through the Verilated unit, and a comparison of methods.

mod methods;
mod sweep;

pub use methods::{Method, Methods, Peer};
pub use sweep::{ExponentialReport, ExponentialSweep, PieceTable};
