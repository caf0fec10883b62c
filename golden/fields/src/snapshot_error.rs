//! Errors of Instant-NGP snapshots.

use std::path::PathBuf;

use potamoi_base::file_keys::KeyError;
use thiserror::Error;

/// A snapshot that is invalid or not supported.
#[derive(Debug, Error)]
pub enum SnapshotError {
    /// The file system returned an error.
    #[error("cannot read snapshot {path}: {source}; name a readable file")]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the file system.
        source: std::io::Error,
    },
    /// The file is not a snapshot.
    #[error(
        "snapshot {path}: {}{problem}; expected what Instant-NGP saves",
        place(field)
    )]
    Container {
        /// The file.
        path: PathBuf,
        /// Path of the invalid field.
        field: String,
        /// The problem.
        problem: String,
    },
    /// The file has a feature that is not supported.
    #[error("snapshot {path}: {source}")]
    Key {
        /// The file.
        path: PathBuf,
        /// The key, and why it is refused.
        source: Box<KeyError>,
    },
    /// A field is invalid or selects a variant that is not supported.
    #[error("snapshot {path}: `{field}` is {found}; expected {expected}")]
    Field {
        /// The file.
        path: PathBuf,
        /// Path of the field.
        field: String,
        /// Its value.
        found: String,
        /// Allowed values.
        expected: String,
    },
}

/// Names a field of the document in messages; empty for the whole document.
fn place(field: &str) -> String {
    match field {
        "" | "." => String::new(),
        field => format!("field `{field}`: "),
    }
}
