//! Why a path could not be modelled.

use thiserror::Error;

use super::costs::CostError;
use super::job_scheduler::JobError;

/// A path that could not be modelled.
#[derive(Debug, Error)]
pub enum ModelError {
    /// Energy that is not known.
    #[error(transparent)]
    Cost(#[from] CostError),
    /// Jobs that cannot be run.
    #[error(transparent)]
    Engine(#[from] JobError),
    /// A frame that waits for itself.
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
