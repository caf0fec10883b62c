//! What can go wrong at the border to rust-hdl.

use potamoi_netlist::InterpretError;
use thiserror::Error;

/// A netlist that rust-hdl cannot take, or a wrong use of its ports.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum BridgeError {
    /// The interpreter refuses what it is asked for.
    #[error(transparent)]
    Interpret(#[from] InterpretError),
    /// rust-hdl gives this name to the outermost module.
    #[error("a module is named `top`, as rust-hdl names the outermost one: give it another name")]
    NamedTop,
    /// A port was read or set with a value of another width.
    #[error(
        "port `{port}` of {module} has {bits} bits, and was used with {used}: use a value of {bits} bits"
    )]
    Width {
        /// The module.
        module: String,
        /// The port.
        port: String,
        /// Bits of the port.
        bits: u32,
        /// Bits of the value.
        used: u64,
    },
}
