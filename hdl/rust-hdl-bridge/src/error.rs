//! Errors of the bridge to rust-hdl.

use potamoi_netlist::InterpretError;
use thiserror::Error;

/// A netlist that rust-hdl cannot use, or misuse of its ports.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum BridgeError {
    /// The interpreter refuses a call.
    #[error(transparent)]
    Interpret(#[from] InterpretError),
    /// The top module has a name that rust-hdl reserves.
    #[error("a module is named `top`, as rust-hdl names the outermost one: give it another name")]
    NamedTop,
    /// A port was read or written with another width.
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
