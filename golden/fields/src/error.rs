//! Errors of fields.

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::snapshot_error::SnapshotError;
use potamoi_containers::torch::TorchError;
use potamoi_march::MarchError;

/// A field that cannot be loaded or rendered.
#[derive(Debug, Error)]
pub enum FieldError {
    /// The checkpoint is invalid or not supported.
    #[error(transparent)]
    Checkpoint(#[from] TorchError),
    /// The snapshot is invalid or not supported.
    #[error(transparent)]
    Snapshot(#[from] SnapshotError),
    /// Rendering in the hardware's formats failed.
    #[error(transparent)]
    Voxels(#[from] MarchError),
    /// The field has no fixed-point feature computation.
    #[error("this kind of field is rendered in floating point alone: use --numerics float")]
    FloatOnly,
    /// An error in the content of a file.
    #[error("model {path}: {source}; the file is damaged, or of a variant that is not read")]
    File {
        /// The file.
        path: PathBuf,
        /// The error.
        source: Box<FieldError>,
    },
    /// An option contradicts the content of a file.
    #[error("scene {path}: {problem}")]
    Asked {
        /// The file.
        path: PathBuf,
        /// The option, and the allowed values.
        problem: String,
    },
    /// A part of a field does not fit the others.
    #[error("field: `{part}` is {found}; expected {expected}")]
    Part {
        /// The part.
        part: &'static str,
        /// Its value.
        found: String,
        /// Allowed values.
        expected: String,
    },
}

impl FieldError {
    /// Whether the message names a file.
    pub const fn names_file(&self) -> bool {
        matches!(
            self,
            Self::Checkpoint(_) | Self::Snapshot(_) | Self::File { .. } | Self::Asked { .. }
        )
    }

    /// Adds the name of the file, unless the error has one.
    pub fn of_file(self, path: &Path) -> Self {
        if self.names_file() {
            return self;
        }
        Self::File {
            path: path.to_owned(),
            source: Box::new(self),
        }
    }
}
