//! Errors of meshes.

use std::path::PathBuf;

use thiserror::Error;

use potamoi_base::file_keys::KeyError;
use potamoi_containers::ply::PlyFileError;

/// A mesh that cannot be made or read.
#[derive(Debug, Error)]
pub enum MeshError {
    /// The vertices or triangles are invalid.
    #[error("mesh: {field} is {value}: expected {expected}")]
    Value {
        /// The field.
        field: String,
        /// Its value.
        value: String,
        /// Allowed values.
        expected: String,
    },
    /// The file system returned an error.
    #[error("cannot read {path}: {source}; name a readable OBJ or PLY file")]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the file system.
        source: std::io::Error,
    },
    /// The file extension belongs to no known format.
    #[error("{path}: unknown kind of mesh: expected a name that ends in .obj or .ply")]
    Unknown {
        /// The file.
        path: PathBuf,
    },
    /// The header of a PLY file is invalid.
    #[error(transparent)]
    Ply(#[from] PlyFileError),
    /// The file has a feature that depth does not support.
    #[error("{origin}: {source}")]
    Key {
        /// The file.
        origin: String,
        /// The key, and why it is refused.
        source: Box<KeyError>,
    },
    /// A field of the file has an invalid value.
    #[error("{origin}: {field} is {value}: expected {expected}")]
    Field {
        /// The file.
        origin: String,
        /// The field with its position.
        field: String,
        /// Its value.
        value: String,
        /// Allowed values.
        expected: String,
    },
}
