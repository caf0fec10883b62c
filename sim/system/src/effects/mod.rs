//! Cost of rendering effects in simulation: cycles of the units by effect, and a digest of all
//! calls.

mod digest;
mod meter;

pub use digest::Digest;
pub use meter::{EffectCycles, EffectMeter};
