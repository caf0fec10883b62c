//! Power of a unit in cells: the library's tables, and what moves in the netlist while
//! it does a share of a scene's work.
//!
//! Energy is of three kinds. *Switching*: half of C V^2 for each change of a net, C the
//! capacitance of the pins that it goes to. *Internal*: the library's `internal_power`
//! by the input that causes it, its transition and the output's load, in the state in
//! which the cell is. *Clock*: both of the flip-flops' clock pins. Transitions are those
//! that the library gives along the way, rising and falling as their mean. Leakage is
//! that of a cell in no particular state.
//!
//! The netlist is run twice: once in which each net changes at most once a cycle, and
//! once with the cells' delays, so that glitches are counted too. Both runs are compared
//! with golden values in every output bit and every cycle.

mod activity;
mod cell;
mod compose;
mod count;
mod estimate;
mod library;
mod measure;
mod report;
mod still;
mod table;
#[cfg(test)]
mod tests;
mod total;
mod verify;

pub use activity::{GatherWindow, Sampler, VectorWindow};
pub use estimate::{Extent, Order, POWER_STEPS, estimate};
pub use report::{Activity, Figures, ModulePower, Power, PowerReport};
pub use verify::{Verified, verify_netlist};

use super::gates::Gate;
use super::{Library, SynthError};
use library::PowerLibrary;

/// Picoseconds of the transition that inputs are taken to have: none where the library does
/// not say.
pub(super) fn usual_transition_ps(library: &Library) -> Result<Option<f64>, SynthError> {
    let own = PowerLibrary::read(library)?;
    match own.transition() {
        Ok(transition) => Ok(Some(transition * own.units.time_ps)),
        Err(Lack::Absent(_)) => Ok(None),
        Err(Lack::Wrong(error)) => Err(error),
    }
}

/// Why there is no estimate.
#[derive(Debug)]
enum Lack {
    /// The library does not say.
    Absent(String),
    /// Something is wrong.
    Wrong(SynthError),
}

impl Lack {
    fn of(gate: &Gate, what: &str) -> Self {
        Self::Absent(format!("the library's cell {} has {what}", gate.name))
    }
}

impl From<SynthError> for Lack {
    fn from(error: SynthError) -> Self {
        Self::Wrong(error)
    }
}
