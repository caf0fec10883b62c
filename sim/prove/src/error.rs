//! Why there is no proof and no counterexample.

use potamoi_netlist::IrErrors;
use potamoi_verilated::child::Fault;
use thiserror::Error;

/// Why a run gives no outcome.
#[derive(Debug, Error)]
pub enum ProveError {
    /// A program is missing.
    #[error(
        "{tool} is not in PATH: without it there are no proofs; to get it: {remedy}; tools/setup puts it into .tools/bin, which PATH must then have"
    )]
    Missing {
        /// The program.
        tool: &'static str,
        /// How to get it.
        remedy: &'static str,
    },
    /// A program fails, or does not end in time.
    #[error("{tool} on {unit}: {fault}")]
    Broken {
        /// The program.
        tool: &'static str,
        /// The unit.
        unit: String,
        /// The fault.
        fault: Fault,
    },
    /// A program says something else than an outcome.
    #[error("{tool} on {unit} gives no outcome; it ends with:\n{said}")]
    NoOutcome {
        /// The program.
        tool: &'static str,
        /// The unit.
        unit: String,
        /// The end of its output.
        said: String,
    },
    /// A file cannot be written.
    #[error("{0}: the proof's files in the folder for temporary files: {1}")]
    Files(String, std::io::Error),
    /// An edit does not fit.
    #[error("{0}: there is no `{1}` to edit")]
    NoPlace(String, String),
    /// The unit cannot be built.
    #[error(transparent)]
    Netlist(#[from] IrErrors),
}
