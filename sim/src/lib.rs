//! Runs golden traces on generated hardware and predicts its cycles; schedules
//! what warping renders; synthesises units to cells.

pub mod cycles;
pub mod effects;
pub mod gates;
pub mod kept;
pub mod layouts;
pub mod rtl;
pub mod runtime;
pub mod soc;
pub mod synth;
pub mod verify;
