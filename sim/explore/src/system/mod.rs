//! The whole system: variants against the baseline, fidelity of the model, and sensitivity to
//! assumptions.

mod accelerators;
mod conclusions;
mod counted_scene;
mod fidelity;
mod merging;
mod modelled;
mod moved;
mod paper;
mod sensitivity;

pub use accelerators::{Accelerators, NEUREX_SIDE};
pub use conclusions::{Conclusion, ModelErrorNote};
pub use counted_scene::CountedScene;
pub use fidelity::{Fidelity, Rung, rungs};
pub use merging::{Merging, Side};
pub use modelled::{Modelled, PathPairs};
pub use moved::Moved;
pub use paper::{BY_TRAFFIC, Paper, frames_per_second, gathering_speed_up};
pub use sensitivity::{Mean, Sensitivity, SensitivityRow, with_free_gpu};
