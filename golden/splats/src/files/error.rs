//! What a splat file can have wrong.

use std::path::PathBuf;

use thiserror::Error;

use crate::CloudError;
use crate::ply::PlyError;
use potamoi_base::record::{KeyError, told};
use potamoi_containers::ply::PlyFileError;

/// A file that holds no readable cloud.
#[derive(Debug, Error)]
pub enum FileError {
    /// The file system refused.
    #[error("cannot read {path}: {source}; name a readable splat file")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The ending of the name is that of no format.
    #[error("{path}: not known as a splat file: expected {expected}")]
    Unknown {
        /// The file.
        path: PathBuf,
        /// The endings that are known.
        expected: String,
    },
    /// A PLY file cannot be used.
    #[error(transparent)]
    Ply(#[from] PlyError),
    /// The container of a PLY file cannot be read.
    #[error(transparent)]
    PlyFile(#[from] PlyFileError),
    /// A field of the file has a value that it cannot have.
    #[error("{origin}: {field} is {value}: expected {expected}")]
    Field {
        /// The file.
        origin: String,
        /// The field.
        field: String,
        /// Its value.
        value: String,
        /// What would be right.
        expected: String,
    },
    /// Something that cannot be honoured.
    #[error("{origin}: {source}")]
    Key {
        /// The file.
        origin: String,
        /// What, and why.
        source: Box<KeyError>,
    },
    /// A part of the file cannot be unpacked.
    #[error("{origin}: {part}: {message}; the file is damaged or of another format")]
    Part {
        /// The file.
        origin: String,
        /// Which part of it.
        part: String,
        /// What is wrong with it.
        message: String,
    },
    /// Values that make no cloud.
    #[error("{origin}: {source}")]
    Cloud {
        /// The file.
        origin: String,
        /// Why.
        source: CloudError,
    },
}

/// Characters of the name of a part that are told.
const LONGEST: usize = 200;

/// Errors of one file.
#[derive(Debug, Clone, Copy)]
pub struct Origin<'a>(pub &'a str);

impl Origin<'_> {
    /// A field with a value that it cannot have.
    pub fn field(
        self,
        field: impl Into<String>,
        value: impl ToString,
        expected: impl Into<String>,
    ) -> FileError {
        FileError::Field {
            origin: self.0.to_owned(),
            field: field.into(),
            value: told(&value.to_string()),
            expected: expected.into(),
        }
    }

    /// A part that cannot be unpacked.
    pub fn part(self, part: impl Into<String>, message: impl ToString) -> FileError {
        let message = message.to_string();
        FileError::Part {
            origin: self.0.to_owned(),
            part: part.into().chars().take(LONGEST).collect(),
            message: message.split_whitespace().collect::<Vec<_>>().join(" "),
        }
    }

    /// Something that cannot be honoured.
    pub fn key(self, source: KeyError) -> FileError {
        FileError::Key {
            origin: self.0.to_owned(),
            source: source.into(),
        }
    }

    /// Values that make no cloud.
    pub fn cloud(self, source: CloudError) -> FileError {
        FileError::Cloud {
            origin: self.0.to_owned(),
            source,
        }
    }
}
