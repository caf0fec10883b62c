//! What effects cost when they are simulated: cycles of the units by what they are for, and a
//! digest of all that goes through them.

mod digest;
mod meter;

pub use digest::Digest;
pub use meter::{EffectCycles, EffectMeter};
