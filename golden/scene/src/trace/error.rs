//! Errors of trace files.

use std::path::PathBuf;

use thiserror::Error;

/// A trace that cannot be written or read.
#[derive(Debug, Error)]
pub enum TraceError {
    /// The file system returned an error.
    #[error("cannot {doing} trace {path}: {source}; name a file that can be read or written")]
    File {
        /// The file.
        path: PathBuf,
        /// "read" or "write".
        doing: &'static str,
        /// The error of the file system.
        source: std::io::Error,
    },
    /// The file is not an NPZ file, or is truncated.
    #[error(
        "trace {path}: {problem}; expected an NPZ file that `potamoi trace` wrote, whole: \
         write it again"
    )]
    Container {
        /// The file.
        path: PathBuf,
        /// The problem.
        problem: String,
    },
    /// An array is missing, unexpected, out of order, truncated or changed.
    #[error("trace {path}: array `{array}`: {problem}; write the trace again")]
    Array {
        /// The file.
        path: PathBuf,
        /// The array.
        array: String,
        /// The problem and the expected content.
        problem: String,
    },
    /// The trace belongs to another configuration.
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
