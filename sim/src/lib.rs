//! Runs golden traces on generated hardware and predicts its cycles.

pub mod cycles;
pub mod rtl;
pub mod verify;
