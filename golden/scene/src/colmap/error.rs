//! Why poses cannot be used.

use std::path::PathBuf;

use thiserror::Error;

/// Poses that cannot be used.
#[derive(Debug, Error)]
pub enum ColmapError {
    /// The file system refused.
    #[error(
        "cannot read poses {path}: {source}; name a folder with COLMAP's cameras.txt and \
         images.txt (colmap model_converter --output_type TXT writes them)"
    )]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A file that is no such text as a whole.
    #[error("poses {path}: {found}: expected {expected}")]
    File {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        found: String,
        /// What would be right.
        expected: String,
    },
    /// A line that says something else.
    #[error("poses {path}, line {line}: {field} is {value}: expected {expected}")]
    Line {
        /// The file.
        path: PathBuf,
        /// Its line, from 1.
        line: usize,
        /// The field, as COLMAP names it.
        field: &'static str,
        /// Its value.
        value: String,
        /// What would be right.
        expected: String,
    },
}

/// What is wrong in a line: field, value, what was expected.
pub(super) type Wrong = (&'static str, String, String);
