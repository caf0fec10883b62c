//! PLY files with any content: the header, the rows of elements, and their errors. Gaussians and
//! meshes are read through this module.

pub mod header;
pub mod rows;

use std::fs::File;
use std::io::BufReader;
use std::path::{Path, PathBuf};

use thiserror::Error;

/// A file that is not valid PLY.
#[derive(Debug, Error)]
pub enum PlyFileError {
    /// The file system returned an error.
    #[error("cannot read {path}: {source}; name a readable PLY file")]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the file system.
        source: std::io::Error,
    },
    /// The file does not begin with `ply`.
    #[error("{origin}: not a PLY file: expected the line `ply` first")]
    NotPly {
        /// The file.
        origin: String,
    },
    /// The header has no end within the limit.
    #[error(
        "{origin}: no `end_header` line within {limit} bytes: the file is cut off, or not a PLY \
         file"
    )]
    NoHeaderEnd {
        /// The file.
        origin: String,
        /// Bytes searched.
        limit: usize,
    },
    /// The header is invalid.
    #[error("{origin}: header: {message}")]
    Header {
        /// The file.
        origin: String,
        /// The problem, with its position.
        message: String,
    },
    /// The file has fewer bytes than the header declares.
    #[error(
        "{origin}: the header declares at least {needed} bytes of elements, but {found} follow \
         it: the file is cut off, or its header is wrong"
    )]
    Truncated {
        /// The file.
        origin: String,
        /// Minimum size of the elements.
        needed: u128,
        /// Bytes after the header.
        found: u64,
    },
    /// An element is invalid.
    #[error("{origin}: element `{element}` {index}: {message}")]
    Element {
        /// The file.
        origin: String,
        /// Name of the element.
        element: String,
        /// Index of the row, from 0.
        index: usize,
        /// The problem.
        message: String,
    },
}

/// Opens a regular file and returns its length.
pub fn open(path: &Path) -> Result<(BufReader<File>, u64), PlyFileError> {
    let fail = |source| PlyFileError::Read {
        path: path.to_owned(),
        source,
    };
    let file = potamoi_base::files::open(path).map_err(fail)?;
    let length = file.metadata().map_err(fail)?.len();
    Ok((BufReader::with_capacity(1 << 16, file), length))
}
