//! What can be wrong with a trace file.

use std::path::PathBuf;

use thiserror::Error;

/// A trace that cannot be written or read.
#[derive(Debug, Error)]
pub enum TraceError {
    /// The file system refused.
    #[error("cannot {doing} trace {path}: {source}; name a file that can be read or written")]
    File {
        /// The file.
        path: PathBuf,
        /// "read" or "write".
        doing: &'static str,
        /// Why.
        source: std::io::Error,
    },
    /// No NPZ file, or its directory is cut off.
    #[error(
        "trace {path}: {problem}; expected an NPZ file that `potamoi trace` wrote, whole: \
         write it again"
    )]
    Container {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        problem: String,
    },
    /// An array is missing, too many, out of place, cut off or changed.
    #[error("trace {path}: array `{array}`: {problem}; write the trace again")]
    Array {
        /// The file.
        path: PathBuf,
        /// The array.
        array: String,
        /// What is wrong and what was expected.
        problem: String,
    },
    /// Of another configuration.
    #[error(
        "trace {path} is of configuration {found}: expected {expected}; give the configuration \
         it was written for with --config, or write the trace again"
    )]
    Configuration {
        /// The file.
        path: PathBuf,
        /// Hash in the trace.
        found: String,
        /// Hash of the configuration in use.
        expected: String,
    },
}
