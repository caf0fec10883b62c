//! Effects that a scene and a camera path call for: the cost of each, and results with effects
//! forced or left out.

mod compare;
mod hardware;
mod report;
mod wall_time;
mod work;

pub use compare::{Forced, Without};
pub use hardware::{Figure, HardwareSaving};
pub use report::{EffectCost, EffectSaving, Effects, EffectsStudy, FoundEffect, UnitUse};
pub use wall_time::{Pairs, RtlWall, Wall};
pub use work::Work;
