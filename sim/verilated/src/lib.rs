//! Builds, loads and drives [Verilator](https://verilator.org) models of any Verilog at run
//! time, without compiling Rust again.
//!
//! [`Toolchain::detect`] finds Verilator 5 and a C++ compiler. [`ModelBuilder`] compiles Verilog
//! text to a [`Library`], which is cached by content, and [`Library::model`] creates instances.
//! Ports of any width are read and written through [`PortId`] handles, in a few nanoseconds per
//! access. [`peer`] compares the speed with a C++ test bench.
//!
//! Assertions are enabled. Registers and unknown values start with values drawn from a seed, so
//! that a missing reset shows. A design that stops itself (`$fatal`, `$stop`, `$finish`, a
//! failed assertion) gives an error and does not end the process. Linux and other systems with
//! ELF libraries are supported.
//!
//! ```
//! use potamoi_verilated::{Direction, ModelBuilder, Toolchain};
//!
//! # fn main() -> Result<(), potamoi_verilated::Error> {
//! # let folder = std::env::temp_dir().join("potamoi-verilated-example");
//! let library = ModelBuilder::new("sum")
//!     .source(
//!         "sum.v",
//!         "module sum(input clk, input [99:0] a, output reg [99:0] q);
//!            initial q = 0;
//!            always @(posedge clk) q <= q + a;
//!          endmodule",
//!     )
//!     .port("a", 100, Direction::Input)
//! #   .cache_dir(folder)
//!     .build(&Toolchain::detect()?)?;
//!
//! let mut model = library.model(1)?;
//! let (clk, a, q) = (model.clock("clk")?, model.port("a")?, model.port("q")?);
//! model.set_words(a, &[0x8000_0000, 0, 0, 1])?;
//! for _ in 0..3 {
//!     model.tick(clk)?;
//! }
//! assert_eq!(model.words(q)?, [0x8000_0000, 1, 0, 3]);
//! # Ok(())
//! # }
//! ```
#![allow(
    unsafe_code,
    reason = "a model is C++ code in a library loaded at run time; everything public is safe"
)]

mod builder;
pub mod cache;
pub mod child;
mod commands;
mod compile;
mod error;
mod headers;
mod library;
mod model;
pub mod peer;
mod ports;
mod store;
mod toolchain;

pub use builder::{ModelBuilder, Opt, Trace, Warnings};
pub use error::{Error, Stop};
pub use library::Library;
pub use model::{Clock, Model};
pub use ports::{Direction, Port, PortId};
pub use toolchain::Toolchain;
