//! From a netlist to a Verilated model.

use std::sync::Arc;

use potamoi_hdl::ir::{Header, IrErrors, Module, verilog};
use potamoi_verilated::{Direction, Library, ModelBuilder, Toolchain};
use thiserror::Error;

use super::stream::StreamError;

/// The hardware could not be built or run.
#[derive(Debug, Error)]
pub enum RtlError {
    /// Verilator, the compiler or the model failed.
    #[error(transparent)]
    Model(#[from] potamoi_verilated::Error),
    /// The netlist is wrong.
    #[error("the generated netlist is wrong: {0}")]
    Netlist(#[from] IrErrors),
    /// The work does not fit the unit.
    #[error(transparent)]
    Stream(#[from] StreamError),
    /// The unit stopped moving.
    #[error("{unit} made no progress for {cycles} cycles: {state}")]
    Hang {
        /// The unit.
        unit: &'static str,
        /// How long.
        cycles: u64,
        /// How far it got.
        state: String,
    },
    /// Counts and lengths that do not go together.
    #[error("{0}")]
    Usage(String),
}

/// Verilates a module, or finds it in the cache.
///
/// # Errors
/// A missing tool, or a failure of one.
pub fn compile(module: &Arc<Module>) -> Result<Library, RtlError> {
    let tools = Toolchain::detect()?;
    let mut builder = ModelBuilder::new(module.name());
    for (file, text) in verilog(module, &Header::default()) {
        builder = builder.source(file, text);
    }
    if module.is_clocked() {
        builder = builder.port("clk", 1, Direction::Input);
    }
    if module.has_registers() {
        builder = builder.port("rst_n", 1, Direction::Input);
    }
    for port in module.ports() {
        let direction = if port.output {
            Direction::Output
        } else {
            Direction::Input
        };
        builder = builder.port(port.name, port.ty.width, direction);
    }
    Ok(builder.build(&tools)?)
}
