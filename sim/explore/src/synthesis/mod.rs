//! Synthesis of units: several at once, their power for a scene's work, their clock, grids of
//! them, and a comparison of variants.

mod activity;
mod clock;
mod estimate;
mod flow;
mod grid;
mod parallel;
mod study;

pub use activity::{Activity, ActivityScene, ActivityScenes, ActivityWork};
pub use clock::{missed_clock, without_memories};
pub use estimate::{EstimateOf, UnitEstimate};
pub use flow::Flow;
pub use grid::synthesise_grid;
pub use parallel::in_parallel;
pub use study::compare_variants;
