//! PLY files with any content: the header, the rows of elements, and their errors. Gaussians and
//! meshes are read through this module.

pub mod header;
pub mod rows;

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{ElementDef, Encoding, PropertyAccess};
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
    #[error("{origin}: no `end_header` line within {limit} bytes: the file is cut off or no PLY")]
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
        "{origin}: the header declares at least {needed} bytes of elements, {found} follow it: \
         the file is cut off or its header wrong"
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

/// Reads one element; the error is one line.
pub fn read_element<E: PropertyAccess>(
    parser: &Parser<E>,
    reader: &mut impl BufRead,
    encoding: Encoding,
    element: &ElementDef,
) -> Result<E, String> {
    let read = match encoding {
        Encoding::BinaryLittleEndian => parser.read_little_endian_element(reader, element),
        Encoding::BinaryBigEndian => parser.read_big_endian_element(reader, element),
        Encoding::Ascii => {
            let mut line = String::new();
            match reader.read_line(&mut line) {
                Ok(0) => return Err("the file ends before it".to_owned()),
                Ok(_) => parser.read_ascii_element(&line, element),
                Err(e) => Err(e),
            }
        }
    };
    read.map_err(|_| "it has not the values that the header declares".to_owned())
}
