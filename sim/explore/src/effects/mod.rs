//! What a scene and a camera path call for: each effect with its cost, results with effects forced
//! and without them.

mod compare;
mod report;
mod wall;
mod work;

pub use compare::{Forced, Without};
pub use report::{EffectCost, EffectSaving, Effects, EffectsStudy, FoundEffect, UnitUse};
pub use wall::{Pairs, RtlWall, Wall};
pub use work::Work;
