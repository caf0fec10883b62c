//! Potamoi netlists as blocks of [`rust_hdl_core`] designs.
//!
//! A netlist gets its widths from a configuration at run time, but the signals of
//! a rust-hdl kernel have their widths in their types. The crate therefore offers two types:
//!
//! - [`Netlist`] is a block whose ports are known at run time. It can be the
//!   top of a design, or a part of a block that accesses its ports by name.
//! - [`Engine`] is the implementation of a block that declares the ports as rust-hdl
//!   signals. Kernels can use these like the signals of any other block:
//!
//! ```
//! use potamoi_netlist::{Module, ModuleBuilder, Ty};
//! use potamoi_rust_hdl::{Engine, BridgeError};
//! use rust_hdl_core::prelude::*;
//! use std::sync::Arc;
//!
//! #[derive(LogicBlock)]
//! struct Sum {
//!     pub a: Signal<In, Bits<8>>,
//!     pub b: Signal<In, Bits<8>>,
//!     pub sum: Signal<Out, Bits<9>>,
//!     engine: Engine,
//! }
//!
//! impl Sum {
//!     fn new(module: &Arc<Module>) -> Result<Self, BridgeError> {
//!         Ok(Self {
//!             a: Default::default(),
//!             b: Default::default(),
//!             sum: Default::default(),
//!             engine: Engine::new(module, 1)?,
//!         })
//!     }
//! }
//!
//! impl Logic for Sum {
//!     fn update(&mut self) {
//!         self.engine.set("a", self.a.val());
//!         self.engine.set("b", self.b.val());
//!         self.engine.step(false);
//!         self.sum.next = self.engine.get("sum");
//!     }
//!     fn connect(&mut self) {
//!         self.sum.connect();
//!     }
//!     fn hdl(&self) -> Verilog {
//!         self.engine.verilog()
//!     }
//! }
//!
//! let mut m = ModuleBuilder::new("adder");
//! let (a, b) = (m.input("a", Ty::u(8), ""), m.input("b", Ty::u(8), ""));
//! let (a, b) = (m.extend(a, 9), m.extend(b, 9));
//! let sum = m.add(a, b);
//! m.output("sum", sum, "");
//!
//! let mut block = Sum::new(&m.finish().unwrap()).unwrap();
//! block.connect_all();
//! block.a.next = 255.into();
//! block.b.next = 1.into();
//! assert!(simulate(&mut block, 10));
//! assert_eq!(block.sum.val(), 256u64);
//! assert_eq!(block.engine.error(), None);
//! assert!(generate_verilog(&block).contains("adder the_adder"));
//! ```
//!
//! Both simulate with the netlist's interpreter and print the Verilog of the
//! generator, so that a design is simulated and synthesised from one
//! description.

mod engine;
mod error;
mod netlist;
mod text;

pub use engine::Engine;
pub use error::BridgeError;
pub use netlist::Netlist;
