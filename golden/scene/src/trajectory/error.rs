//! Errors of trajectories.

use std::path::{Path, PathBuf};

use thiserror::Error;

/// A trajectory that is invalid or not supported.
#[derive(Debug, Error)]
pub enum TrajectoryError {
    /// The file system returned an error.
    #[error("cannot read trajectory {path}: {source}; name a readable text file of poses")]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the file system.
        source: std::io::Error,
    },
    /// The file as a whole is invalid.
    #[error("trajectory {path}: {found}: expected {expected}")]
    File {
        /// The file.
        path: PathBuf,
        /// The problem.
        found: String,
        /// Allowed content.
        expected: String,
    },
    /// A line is invalid.
    #[error("trajectory {path}, line {line}: {field} is {value}: expected {expected}")]
    Line {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// The field, as the format names it.
        field: &'static str,
        /// Its value.
        value: String,
        /// Allowed values.
        expected: String,
    },
}

impl TrajectoryError {
    pub(super) fn file(path: &Path, found: &str, expected: &str) -> Self {
        Self::File {
            path: path.to_owned(),
            found: found.to_owned(),
            expected: expected.to_owned(),
        }
    }
}

/// An invalid field of a line: field, value, allowed values.
pub(super) type Wrong = (&'static str, String, String);
