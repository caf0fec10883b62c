//! Verilates netlists, and the crate's errors.

use std::collections::BTreeMap;
use std::sync::Arc;

use potamoi_cycles::StreamError;
use potamoi_netlist::{Header, IrErrors, Module, verilog};
use potamoi_verilated::{Direction, Library, ModelBuilder, Opt, Toolchain, Trace, Warnings};
use thiserror::Error;

use super::mismatch::Mismatch;

/// Why hardware could not be built or run.
#[derive(Debug, Error)]
pub enum RtlError {
    /// Verilator, the compiler or the model failed.
    #[error(transparent)]
    Model(#[from] potamoi_verilated::Error),
    /// The netlist is invalid.
    #[error("the generated netlist is invalid: {0}")]
    Netlist(#[from] IrErrors),
    /// The interpreter was misused.
    #[error(transparent)]
    Interpreter(#[from] potamoi_netlist::InterpretError),
    /// A tool is missing.
    #[error("{tool} is missing, which disables {disables}; {get}")]
    MissingTool {
        /// Its program name.
        tool: &'static str,
        /// What needs it.
        disables: &'static str,
        /// How to get it.
        get: &'static str,
    },
    /// A tool is broken, whatever its input.
    #[error("{tool} does not work: {fault}; `potamoi doctor` lists the tools found")]
    BrokenTool {
        /// Its program name.
        tool: &'static str,
        /// The fault.
        fault: potamoi_verilated::child::Fault,
    },
    /// Icarus Verilog failed.
    #[error("Icarus Verilog: {0}")]
    Icarus(String),
    /// No temporary folder could be created.
    #[error(
        "cannot write the folder for temporary files: {0}; set TMPDIR to a folder that can be \
         written"
    )]
    Folder(std::io::Error),
    /// The work cannot be done, or its cycles cannot be modelled.
    #[error(transparent)]
    Work(#[from] potamoi_cycles::WorkError),
    /// A fault cannot be injected.
    #[error(transparent)]
    Fault(#[from] potamoi_netlist::FaultError),
    /// The work does not fit the unit.
    #[error(transparent)]
    Stream(#[from] StreamError),
    /// Hardware and prediction differ.
    #[error(transparent)]
    Mismatch(#[from] Box<Mismatch>),
    /// The unit hangs.
    #[error("{unit} made no progress for {cycles} cycles: {state}")]
    Hang {
        /// The unit.
        unit: &'static str,
        /// Cycles without progress.
        cycles: u64,
        /// State in which it stopped.
        state: String,
    },
    /// Arguments contradict each other.
    #[error("{0}")]
    Usage(String),
}

/// Verilates a module, or takes it from the cache. `traced` models can dump their signals, and are
/// slower.
///
/// # Errors
/// A missing or failing tool.
pub fn compile(module: &Arc<Module>, traced: bool) -> Result<Library, RtlError> {
    let tools = Toolchain::detect()?;
    let trace = if traced { Trace::Vcd } else { Trace::Off };
    Ok(model(module).trace(trace).build(&tools)?)
}

/// The module's Verilog and ports, ready to be built.
#[must_use]
pub fn model(module: &Arc<Module>) -> ModelBuilder {
    model_of_files(module, &verilog(module, &Header::default()))
}

/// The paper's vector unit is built in 5.5 s with `-O3` and in 4.5 s with `-O1`, and then takes 1.0 and
/// 1.3 us a clock. Debug builds of this program run tests, whose models run briefly.
const OPTIMISE: Opt = match cfg!(debug_assertions) {
    true => Opt::O1,
    false => Opt::O3,
};

/// Other Verilog with the ports of a module.
fn model_of_files(module: &Arc<Module>, files: &BTreeMap<String, String>) -> ModelBuilder {
    let mut builder = ModelBuilder::new(module.name()).optimise(OPTIMISE);
    for (file, text) in files {
        builder = builder.source(file, text);
    }
    if module.is_clocked() {
        builder = builder.port("clk", 1, Direction::Input);
    }
    if module.has_reset() {
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
    builder
}

/// The model of Verilog of others with the ports of a module, such as its netlist of gates.
pub(super) fn model_of_others(
    module: &Arc<Module>,
    files: &BTreeMap<String, String>,
) -> ModelBuilder {
    model_of_files(module, files).warnings(Warnings::Allow)
}
