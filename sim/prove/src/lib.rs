//! Proofs of the checks in the emitted Verilog, by induction.
//!
//! A unit is proven as a whole. What carries only data is left out: modules without checks in them
//! give any outputs, one bit of a payload stands for all, and counters are narrow. Each of these lets
//! the unit do more than it can, so that a property that holds then holds of the unit.
//!
//! All properties and invariants of a unit are proven together, by induction over one clock: if all
//! hold in a cycle, they hold in the next. What is not inductive is looked for in all runs of a
//! number of cycles after reset instead, and is then *bounded*, not proven.

mod error;
mod script;
mod solver;
mod tools;
mod unit;

pub use error::ProveError;
pub use tools::Tools;
pub use unit::{Options, Proof, Unit, top_as_built, units, units_as_built};

use schemars::JsonSchema;
use serde::Serialize;

/// What is known of a property.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "outcome", content = "depth")]
pub enum Outcome {
    /// It holds in all runs.
    Proven,
    /// It holds in all runs of so many cycles.
    Bounded(u32),
    /// It does not hold in this cycle of some run.
    Failed(u32),
    /// A cover point is reached in this cycle of some run.
    Reached(u32),
    /// A cover point is not reached within so many cycles.
    NotReached(u32),
}

impl Outcome {
    /// Whether the outcome is at least as good as `expected`.
    #[must_use]
    pub const fn keeps(self, expected: Self) -> bool {
        match (self, expected) {
            (Self::Proven, Self::Proven | Self::Bounded(_)) => true,
            (Self::Bounded(found), Self::Bounded(depth)) => found >= depth,
            (Self::Reached(_), Self::Reached(_) | Self::NotReached(_)) => true,
            (Self::NotReached(found), Self::NotReached(depth)) => found >= depth,
            _ => false,
        }
    }
}

/// A property of a unit, and what is known of it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Property {
    /// Instances from the unit on, and its name, joined by dots.
    pub name: String,
    /// What it says.
    pub says: String,
    /// Whether it only supports the proof of others.
    pub supports: bool,
    /// What is known.
    #[serde(flatten)]
    pub outcome: Outcome,
}
