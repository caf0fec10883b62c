//! What can be wrong with a mesh.

use std::path::PathBuf;

use thiserror::Error;

use potamoi_base::record::KeyError;
use potamoi_containers::ply::PlyFileError;

/// A mesh that cannot be made or read.
#[derive(Debug, Error)]
pub enum MeshError {
    /// Vertices or triangles that make no mesh.
    #[error("mesh: {field} is {value}: expected {expected}")]
    Value {
        /// The field.
        field: String,
        /// Its value.
        value: String,
        /// What would be right.
        expected: String,
    },
    /// The file system refused.
    #[error("cannot read {path}: {source}; name a readable OBJ or PLY file")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The ending of the name is that of no format.
    #[error("{path}: not known as a mesh: expected a name that ends in .obj or .ply")]
    Unknown {
        /// The file.
        path: PathBuf,
    },
    /// The header of a PLY file cannot be used.
    #[error(transparent)]
    Ply(#[from] PlyFileError),
    /// The file says something that no depth is taken of.
    #[error("{origin}: {source}")]
    Key {
        /// The file.
        origin: String,
        /// The key, and why.
        source: Box<KeyError>,
    },
    /// A field of the file has a value that it cannot have.
    #[error("{origin}: {field} is {value}: expected {expected}")]
    Field {
        /// The file.
        origin: String,
        /// The field, and where it is.
        field: String,
        /// Its value.
        value: String,
        /// What would be right.
        expected: String,
    },
}
