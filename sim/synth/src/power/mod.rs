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
mod lack;
mod library;
mod measure;
mod order;
mod still;
mod table;
#[cfg(test)]
mod tests;
mod total;
mod verify;

pub use activity::{GatherWindow, Sampler, VectorWindow};
pub use estimate::{POWER_STEPS, estimate};
pub(super) use library::usual_transition_ps;
pub use order::{Extent, Order};
pub use verify::{Verified, verify_netlist};
