//! Simulates gate-level netlists written by Yosys, with the functions of the library's cells, with
//! or without delays.
//!
//! ```
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! use std::collections::BTreeMap;
//! use std::sync::Arc;
//!
//! use potamoi_gates::{Flat, Gate, NoCount, Simulator, Truth};
//!
//! let inverter = Gate {
//!     name: "INV".to_owned(),
//!     inputs: vec!["A".to_owned()],
//!     outputs: vec!["Y".to_owned()],
//!     functions: vec![Truth::parse("!A", &["A"])?],
//!     flop: None,
//! };
//! let netlist = "module top(a, y);\n input a;\n output y;\n INV i (.A(a), .Y(y));\nendmodule\n";
//! let gates = BTreeMap::from([("INV".to_owned(), Ok(inverter))]);
//! let flat = Arc::new(Flat::new(netlist, "top", &gates, &BTreeMap::new())?);
//! let mut simulator = Simulator::new(&flat, None, 0, NoCount)?;
//! let [a, y] = [0, 1].map(|port| flat.ports[port].nets[0]);
//! simulator.set(a, true);
//! simulator.settle()?;
//! assert!(!simulator.value(y));
//! # Ok(())
//! # }
//! ```

mod flat;
mod flatten;
mod function;
mod gate;
mod memory;
mod simulate;
mod verilog;
mod watch;

pub use flat::{Cell, Driver, Flat, FlatMemory, FlatPort, ModuleKind, Sink};
pub use function::{MAX_VARIABLES, Truth};
pub use gate::{Flop, Gate};
pub use simulate::Simulator;
pub use watch::{Delays, NoCount, Watch};
