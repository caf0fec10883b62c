//! Errors of interpretation.

use num_bigint::BigInt;
use thiserror::Error;

/// Misuse of an [`Interpreter`](super::Interpreter), or a value outside its proven range.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum InterpretError {
    /// There is no such port.
    #[error("module {module} has no port `{name}`; its ports are {ports}")]
    NoSuchPort {
        /// The module.
        module: String,
        /// The requested name.
        name: String,
        /// Names of its ports.
        ports: String,
    },
    /// A port handle of another module's interpreter.
    #[error("this handle is of a port of another module: get it from this interpreter's port()")]
    ForeignPort,
    /// A write to an output.
    #[error("port `{0}` is an output: only inputs can be set")]
    NotAnInput(String),
    /// The port does not fit the call.
    #[error("port `{name}` has {bits} bits, {words} words of 32: {got}")]
    WrongWidth {
        /// The port.
        name: String,
        /// Its width.
        bits: u32,
        /// Its width in 32-bit words.
        words: usize,
        /// The call used, and the right one.
        got: String,
    },
    /// Ranges of another module.
    #[error("the ranges are not of module {0}: derive them from the module that is interpreted")]
    ForeignRanges(String),
    /// A value outside its declared or proven range.
    #[error("{signal} is {value} after {cycle} clock edges: expected {expected}")]
    OutOfRange {
        /// Hierarchical name of the signal.
        signal: String,
        /// Its value.
        value: BigInt,
        /// The range and its source.
        expected: String,
        /// Clock edges since the start.
        cycle: u64,
    },
}
