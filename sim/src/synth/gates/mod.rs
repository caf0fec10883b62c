//! Netlists in cells, run: what Yosys wrote, flattened, with the functions of the
//! library's cells; without delays or with them.

pub(crate) mod flat;
mod flatten;
mod function;
pub(crate) mod gate;
mod mapped;
mod memory;
mod simulate;
mod verilog;
mod watch;

pub(crate) use flat::Flat;
pub(crate) use function::Truth;
pub(crate) use gate::Gate;
pub use mapped::{cell_functions, netlist};
pub(crate) use simulate::Simulator;
pub(crate) use watch::{Delays, NoCount, Watch};
