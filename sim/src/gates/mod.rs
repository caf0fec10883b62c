//! Netlists in cells, run: what Yosys wrote, flattened, with the functions of the
//! library's cells; without delays or with them.

pub mod flat;
mod flatten;
mod function;
pub mod gate;
mod memory;
mod simulate;
mod verilog;
mod watch;

pub use flat::Flat;
pub use function::{MAX_VARIABLES, Truth};
pub use gate::{Flop, Gate};
pub use simulate::Simulator;
pub use watch::{Delays, NoCount, Watch};
