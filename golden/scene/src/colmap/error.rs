//! Errors of COLMAP poses.

use std::path::PathBuf;

use thiserror::Error;

/// Poses that are invalid or not supported.
#[derive(Debug, Error)]
pub enum ColmapError {
    /// The file system returned an error.
    #[error(
        "cannot read poses {path}: {source}; name a folder with COLMAP's cameras.txt and \
         images.txt (colmap model_converter --output_type TXT writes them)"
    )]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the file system.
        source: std::io::Error,
    },
    /// The file as a whole is invalid.
    #[error("poses {path}: {found}: expected {expected}")]
    File {
        /// The file.
        path: PathBuf,
        /// The problem.
        found: String,
        /// Allowed content.
        expected: String,
    },
    /// A line is invalid.
    #[error("poses {path}, line {line}: {field} is {value}: expected {expected}")]
    Line {
        /// The file.
        path: PathBuf,
        /// Line number, from 1.
        line: usize,
        /// The field, as COLMAP names it.
        field: &'static str,
        /// Its value.
        value: String,
        /// Allowed values.
        expected: String,
    },
}

/// An invalid field of a line: field, value, allowed values.
pub(super) type Wrong = (&'static str, String, String);
