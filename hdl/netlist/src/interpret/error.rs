//! What can go wrong while a netlist is interpreted.

use num_bigint::BigInt;
use thiserror::Error;

/// A wrong use of an [`Interpreter`](super::Interpreter), or a value outside
/// its proven range.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum InterpretError {
    /// There is no such port.
    #[error("module {module} has no port `{name}`; its ports are {ports}")]
    NoSuchPort {
        /// The module.
        module: String,
        /// The name that was asked for.
        name: String,
        /// The names there are.
        ports: String,
    },
    /// A handle of an interpreter of another module.
    #[error("this handle is of a port of another module: get it from this interpreter's port()")]
    ForeignPort,
    /// An output was set.
    #[error("port `{0}` is an output: only inputs can be set")]
    NotAnInput(String),
    /// The port does not fit the call.
    #[error("port `{name}` has {bits} bits, {words} words of 32: {got}")]
    WrongWidth {
        /// The port.
        name: String,
        /// Its width.
        bits: u32,
        /// Its width in words of 32 bits.
        words: usize,
        /// What it was used as, and what to use instead.
        got: String,
    },
    /// Ranges that were derived for another module.
    #[error("the ranges are not of module {0}: derive them from the module that is interpreted")]
    ForeignRanges(String),
    /// A value outside the range that was declared or proven.
    #[error("{signal} is {value} after {cycle} clock edges: expected {expected}")]
    OutOfRange {
        /// The signal, by instances.
        signal: String,
        /// Its value.
        value: BigInt,
        /// The range, and where it comes from.
        expected: String,
        /// Clock edges since the start.
        cycle: u64,
    },
}
