//! The exponential by itself: every input through the Verilated unit, and other ways to find it.

mod methods;
mod sweep;

pub use methods::{Method, Methods, Peer};
pub use sweep::{ExponentialReport, ExponentialSweep, PieceTable};
