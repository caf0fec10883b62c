//! The whole system: variants against the baseline, fidelity and calibration of the model, and
//! sensitivity to assumptions.

mod accelerators;
mod calibration;
mod fidelity;
mod merging;
mod modelled;
mod sensitivity;

pub use accelerators::{Accelerators, NEUREX_SIDE};
pub use calibration::{GpuFactors, SIDE, TIMED, Timed, WARPED};
pub use fidelity::{Fidelity, Rung, rungs};
pub use merging::{Merging, Side};
pub use modelled::Modelled;
pub use sensitivity::{CountedScene, Mean, Sensitivity, SensitivityRow};
