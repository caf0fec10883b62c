//! What can be wrong with a field.

use thiserror::Error;

use super::ngp::SnapshotError;
use crate::torch::TorchError;
use crate::voxels::VoxelError;

/// A field that cannot be loaded or rendered.
#[derive(Debug, Error)]
pub enum FieldError {
    /// A checkpoint cannot be used.
    #[error(transparent)]
    Checkpoint(#[from] TorchError),
    /// A snapshot cannot be used.
    #[error(transparent)]
    Snapshot(#[from] SnapshotError),
    /// The hardware's side of it.
    #[error(transparent)]
    Voxels(#[from] VoxelError),
    /// It has no feature computation in the hardware's formats.
    #[error("this kind of field is rendered in floating point alone: use --numerics float")]
    FloatOnly,
    /// A part of a field does not fit the others.
    #[error("field: `{part}` is {found}; expected {expected}")]
    Part {
        /// The part.
        part: &'static str,
        /// What is there.
        found: String,
        /// What would be right.
        expected: String,
    },
}
