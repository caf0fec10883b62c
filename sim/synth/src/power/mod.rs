//! Power of a gate-level unit, from the library's tables and the transitions in its netlist during
//! a share of a scene's work.
//!
//! Energy has three parts. *Switching*: half of C V^2 for each transition of a net, where C is the
//! capacitance of the pins that it drives. *Internal*: the library's `internal_power` for the input
//! that causes it, its transition and the output's load, in the state of the cell. *Clock*: both
//! parts for the flip-flops' clock pins. Transition times are the library's along each path, as
//! mean of rising and falling. Leakage is that of a cell in no particular state.
//!
//! The netlist is simulated twice: with zero delays, where each net changes at most once a cycle,
//! and with the cells' delays, so that glitches count too. Both runs are compared with golden
//! values in every output bit and every cycle.

mod activity;
mod cell;
mod compose;
mod count;
mod estimate;
mod library;
mod measure;
mod multiply;
mod order;
mod static_data;
mod table;
#[cfg(test)]
mod tests;
mod total;
mod unavailable;
mod verify;

pub use activity::{GatherWindow, Sampler, SplatWindow, VectorWindow};
pub use estimate::{Estimated, POWER_STEPS, estimate};
pub(super) use library::usual_transition_ps;
pub use order::{Extent, Order, Windows};
pub use verify::{Verified, verify_netlist};
