//! The exponential alone: every input through the Verilated unit, a comparison of methods, and prices.

mod methods;
mod price;
mod sweep;

pub use methods::{Method, Methods, Peer};
pub use price::{
    Clocks, ExponentialHardware, ExponentialPrice, Figure, PowerError, Pricing, SceneQuality,
};
pub use sweep::{ExponentialReport, ExponentialSweep, PieceTable};
