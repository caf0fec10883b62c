//! What can be wrong with a snapshot of Instant-NGP.

use std::path::PathBuf;

use potamoi_base::record::KeyError;
use thiserror::Error;

/// A snapshot that cannot be used.
#[derive(Debug, Error)]
pub enum SnapshotError {
    /// The file system refused.
    #[error("cannot read snapshot {path}: {source}; name a readable file")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// It is no snapshot.
    #[error(
        "snapshot {path}: {}{problem}; expected what Instant-NGP saves",
        place(field)
    )]
    Container {
        /// The file.
        path: PathBuf,
        /// Where it went wrong.
        field: String,
        /// What is wrong.
        problem: String,
    },
    /// It says something that no renderer here does.
    #[error("snapshot {path}: {source}")]
    Key {
        /// The file.
        path: PathBuf,
        /// The key, and why.
        source: Box<KeyError>,
    },
    /// Something of it is not as it should be, or of a variant that is not
    /// read.
    #[error("snapshot {path}: `{field}` is {found}; expected {expected}")]
    Field {
        /// The file.
        path: PathBuf,
        /// Path of the field.
        field: String,
        /// What is there.
        found: String,
        /// What would be right.
        expected: String,
    },
}

/// Where in the document something is; nothing of the whole.
fn place(field: &str) -> String {
    match field {
        "" | "." => String::new(),
        field => format!("field `{field}`: "),
    }
}
