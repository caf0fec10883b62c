//! Errors of splat files.

use std::path::PathBuf;

use thiserror::Error;

use crate::CloudError;
use crate::ply::PlyError;
use potamoi_base::file_keys::{KeyError, told};
use potamoi_containers::ply::PlyFileError;

/// A file from which no cloud can be read.
#[derive(Debug, Error)]
pub enum FileError {
    /// The file system returned an error.
    #[error("cannot read {path}: {source}; name a readable splat file")]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the file system.
        source: std::io::Error,
    },
    /// The file extension belongs to no known format.
    #[error("{path}: unknown kind of splat file: expected {expected}")]
    Unknown {
        /// The file.
        path: PathBuf,
        /// The known extensions.
        expected: String,
    },
    /// The format is known and not read.
    #[error(
        "{path}: {format} is not read: convert it, for example by \
         npx @playcanvas/splat-transform {} scene.ply",
        path.display()
    )]
    NotRead {
        /// The file.
        path: PathBuf,
        /// Its format.
        format: &'static str,
    },
    /// The content of a PLY file is invalid.
    #[error(transparent)]
    Ply(#[from] PlyError),
    /// The container of a PLY file cannot be read.
    #[error(transparent)]
    PlyFile(#[from] PlyFileError),
    /// A field of the file has an invalid value.
    #[error("{origin}: {field} is {value}: expected {expected}")]
    Field {
        /// The file.
        origin: String,
        /// The field.
        field: String,
        /// Its value.
        value: String,
        /// Allowed values.
        expected: String,
    },
    /// The file has a feature that is not supported.
    #[error("{origin}: {source}")]
    Key {
        /// The file.
        origin: String,
        /// The feature, and why it is refused.
        source: Box<KeyError>,
    },
    /// A part of the file cannot be decoded.
    #[error("{origin}: {part}: {message}; the file is damaged or of another format")]
    Part {
        /// The file.
        origin: String,
        /// The part.
        part: String,
        /// The error of the decoder.
        message: String,
    },
    /// The values do not form a valid cloud.
    #[error("{origin}: {source}")]
    Cloud {
        /// The file.
        origin: String,
        /// The invalid value.
        source: CloudError,
    },
}

/// Maximum length of a part's name in messages, in characters.
const LONGEST: usize = 200;

/// Builds the errors of the named file.
#[derive(Debug, Clone, Copy)]
pub struct Origin<'a>(pub &'a str);

impl Origin<'_> {
    /// A field has an invalid value.
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

    /// A part cannot be decoded.
    pub fn part(self, part: impl Into<String>, message: impl ToString) -> FileError {
        let message = message.to_string();
        FileError::Part {
            origin: self.0.to_owned(),
            part: part.into().chars().take(LONGEST).collect(),
            message: message.split_whitespace().collect::<Vec<_>>().join(" "),
        }
    }

    /// A feature is not supported.
    pub fn key(self, source: KeyError) -> FileError {
        FileError::Key {
            origin: self.0.to_owned(),
            source: source.into(),
        }
    }

    /// The values do not form a valid cloud.
    pub fn cloud(self, source: CloudError) -> FileError {
        FileError::Cloud {
            origin: self.0.to_owned(),
            source,
        }
    }
}
