//! Why there is no score.

use std::path::PathBuf;

use potamoi_netlist::IrErrors;
use potamoi_prove::ProveError;
use potamoi_rtl::RtlError;
use potamoi_verilated::child::Fault;
use thiserror::Error;

/// Why there is no score.
#[derive(Debug, Error)]
pub enum MutateError {
    /// A program is missing.
    #[error("{tool} is not in PATH: without it there is no mutation score; to get it: {remedy}")]
    Missing {
        /// The program.
        tool: &'static str,
        /// How to get it.
        remedy: &'static str,
    },
    /// A program does not end, or not in time.
    #[error("{tool} on {what}: {fault}")]
    Broken {
        /// The program.
        tool: String,
        /// What it worked on.
        what: String,
        /// The fault.
        fault: Fault,
    },
    /// A program says something else than expected.
    #[error("{tool} on {what} gives no result; it ends with:\n{said}")]
    NoResult {
        /// The program.
        tool: String,
        /// What it worked on.
        what: String,
        /// The end of its output.
        said: String,
    },
    /// A judge finds a fault in the unit without one.
    #[error("the {0} fails on {1} without a fault, so that it judges nothing: {2}")]
    Unmutated(&'static str, String, String),
    /// A file.
    #[error("{}: {error}", path.display())]
    File {
        /// The file.
        path: PathBuf,
        /// The fault.
        #[source]
        error: std::io::Error,
    },
    /// The unit cannot be built.
    #[error(transparent)]
    Netlist(#[from] IrErrors),
    /// The bench cannot be written.
    #[error(transparent)]
    Bench(#[from] RtlError),
    /// A proof gives no outcome.
    #[error(transparent)]
    Proof(#[from] ProveError),
}
