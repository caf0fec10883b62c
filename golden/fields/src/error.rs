//! What can be wrong with a field.

use std::path::{Path, PathBuf};

use thiserror::Error;

use super::snapshot_error::SnapshotError;
use potamoi_containers::torch::TorchError;
use potamoi_march::MarchError;

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
    Voxels(#[from] MarchError),
    /// It has no feature computation in the hardware's formats.
    #[error("this kind of field is rendered in floating point alone: use --numerics float")]
    FloatOnly,
    /// What is wrong with what a file holds.
    #[error("model {path}: {source}; the file is damaged, or of a variant that is not read")]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        source: Box<FieldError>,
    },
    /// What was asked of a file is not what it holds.
    #[error("scene {path}: {problem}")]
    Asked {
        /// The file.
        path: PathBuf,
        /// What was asked for, and what would be right.
        problem: String,
    },
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

impl FieldError {
    /// Whether its text names a file.
    pub const fn names_file(&self) -> bool {
        matches!(
            self,
            Self::Checkpoint(_) | Self::Snapshot(_) | Self::File { .. } | Self::Asked { .. }
        )
    }

    /// Names the file that it was found in, unless it does so itself.
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
