//! Published accelerators, evaluated on the counted work of a frame.
//!
//! A rival is a file of `sim/rivals/rivals/`: its stages with what each takes of the work, units, rates, clock, memory,
//! power and area. Each constant names the publication that states it, is assumed with a reason, or is unknown with
//! one. There is no speed-up among them.
//!
//! | module | contents |
//! |---|---|
//! | [`trace`] | the counted work of a frame, which all rivals take, and its digest |
//! | [`constant`] | a constant with its unit and its origin |
//! | [`rival`] | what a rival is made of, and the figures published for it |
//! | [`estimate`] | the time of a rival's stages on a trace |
//! | [`validation`] | figures of publications, computed again on the workload that is published for them |

pub mod constant;
pub mod estimate;
mod file;
pub mod rival;
#[cfg(test)]
mod tests;
pub mod trace;
pub mod validation;

pub use constant::{Constant, Origin};
pub use estimate::{Estimate, EstimateError, Seconds};
pub use rival::{Overlap, Rival, RivalError};
pub use trace::{Class, Trace};
pub use validation::{Check, Verdict};
