//! Errors of the path model.

use thiserror::Error;

use super::job_scheduler::JobError;

/// Why a path cannot be modelled.
#[derive(Debug, Error)]
pub enum ModelError {
    /// The jobs cannot be run.
    #[error(transparent)]
    Engine(#[from] JobError),
    /// Only full frames were counted.
    #[error("variant {variant}: only full frames of this path were counted: count all parts of it")]
    NotCounted {
        /// The variant that needs more.
        variant: &'static str,
    },
    /// A frame depends on itself.
    #[error(
        "frame {frame} is never rendered: the pose of reference {reference}, which serves it, is \
         not known before it is shown"
    )]
    Unfinished {
        /// The frame.
        frame: usize,
        /// Its reference.
        reference: usize,
    },
}
