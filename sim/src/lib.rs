//! Runs golden traces on generated hardware and predicts its cycles; schedules
//! what warping renders.

pub mod cycles;
pub mod layouts;
pub mod rtl;
pub mod runtime;
pub mod verify;
