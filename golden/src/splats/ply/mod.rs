//! The PLY files of 3D Gaussian splatting.
//!
//! Properties are found by name, in any order: `x y z`, `f_dc_0..2`,
//! `f_rest_*` (channel-major, 0, 9, 24 or 45 of them for degrees 0 to 3),
//! `opacity` (a logit), `scale_0..2` (logarithms), `rot_0..3` (`w, x, y, z`).
//! Others, normals for one, are read past. Binary files of either byte order
//! and text files are read.

pub(crate) mod header;

use std::fs::File;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{ElementDef, Encoding, Property, PropertyAccess};
use thiserror::Error;

use super::cloud::{Cloud, CloudError};
use super::sh;
use header::Columns;

/// A file that holds no readable cloud.
#[derive(Debug, Error)]
pub enum PlyError {
    /// The file system refused.
    #[error("cannot read {path}: {source}; name a readable PLY file")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Does not begin with `ply`.
    #[error("{origin}: not a PLY file: expected the line `ply` first")]
    NotPly {
        /// The file.
        origin: String,
    },
    /// The header has no end within reason.
    #[error("{origin}: no `end_header` line within {limit} bytes: the file is cut off or no PLY")]
    NoHeaderEnd {
        /// The file.
        origin: String,
        /// Bytes searched.
        limit: usize,
    },
    /// The header cannot be understood.
    #[error("{origin}: header: {message}")]
    Header {
        /// The file.
        origin: String,
        /// What is wrong, and where.
        message: String,
    },
    /// A property that a Gaussian needs is not there.
    #[error(
        "{origin}: element `vertex` has no property `{property}`: \
         expected a 3D Gaussian splatting file"
    )]
    Missing {
        /// The file.
        origin: String,
        /// The property.
        property: String,
    },
    /// A number of `f_rest_*` properties that is no degree.
    #[error(
        "{origin}: {found} properties `f_rest_*`: expected 0, 9, 24 or 45 \
         (spherical harmonics of degree 0, 1, 2 or 3)"
    )]
    Degree {
        /// The file.
        origin: String,
        /// Properties found.
        found: usize,
    },
    /// No vertices.
    #[error("{origin}: no Gaussian: element `vertex` must hold at least one")]
    Empty {
        /// The file.
        origin: String,
    },
    /// Fewer bytes than the header declares.
    #[error(
        "{origin}: the header declares at least {needed} bytes of elements, {found} follow it: \
         the file is cut off or its header wrong"
    )]
    Truncated {
        /// The file.
        origin: String,
        /// Bytes that the elements take at least.
        needed: u128,
        /// Bytes there.
        found: u64,
    },
    /// An element cannot be read.
    #[error("{origin}: element `{element}` {index}: {message}")]
    Element {
        /// The file.
        origin: String,
        /// Name of the element.
        element: String,
        /// Which one, from 0.
        index: usize,
        /// What is wrong.
        message: String,
    },
    /// NaN or infinite, where it is not allowed.
    #[error(
        "{origin}: vertex {index}, property `{property}` is {value}: \
         expected a finite number (only `opacity` may be infinite)"
    )]
    NotFinite {
        /// The file.
        origin: String,
        /// Which vertex, from 0.
        index: usize,
        /// The property.
        property: String,
        /// The value.
        value: f64,
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

/// Reads a file.
///
/// # Errors
/// The file cannot be read or is no complete 3D Gaussian splatting PLY file
/// with finite values.
pub fn read(path: &Path) -> Result<Cloud, PlyError> {
    let (reader, length) = open(path)?;
    parse(reader, length, &path.display().to_string())
}

/// Opens a regular file; its length with it.
pub(in crate::splats) fn open(path: &Path) -> Result<(BufReader<File>, u64), PlyError> {
    let fail = |source| PlyError::Read {
        path: path.to_owned(),
        source,
    };
    let file = crate::files::open(path).map_err(fail)?;
    let length = file.metadata().map_err(fail)?.len();
    Ok((BufReader::with_capacity(1 << 16, file), length))
}

/// Reads a cloud from `length` bytes; `origin` names them in errors.
///
/// # Errors
/// As [`read`].
pub fn parse(mut reader: impl BufRead, length: u64, origin: &str) -> Result<Cloud, PlyError> {
    let header = header::read(&mut reader, origin)?;
    let columns = Columns::find(&header.ply, origin)?;
    let found = length.saturating_sub(header.bytes as u64);
    let needed = header::least_bytes(&header.ply);
    if needed > u128::from(found) {
        return Err(PlyError::Truncated {
            origin: origin.to_owned(),
            needed,
            found,
        });
    }
    let parser = Parser::<Scalars>::new();
    for (name, element) in &header.ply.elements {
        let mut vertices = (name == "vertex").then(|| Vertices::new(&columns, element.count));
        for index in 0..element.count {
            let values = read_element(&parser, &mut reader, header.ply.encoding, element).map_err(
                |message| PlyError::Element {
                    origin: origin.to_owned(),
                    element: name.clone(),
                    index,
                    message,
                },
            )?;
            if let Some(v) = &mut vertices {
                v.push(&columns, &values.0)
                    .map_err(|column| PlyError::NotFinite {
                        origin: origin.to_owned(),
                        index,
                        property: element
                            .properties
                            .get_index(column)
                            .map_or_else(String::new, |(n, _)| n.clone()),
                        value: values.0.get(column).copied().unwrap_or(f64::NAN),
                    })?;
            }
        }
        if let Some(v) = vertices {
            return v.finish(&columns).map_err(|source| PlyError::Cloud {
                origin: origin.to_owned(),
                source,
            });
        }
    }
    Err(PlyError::Empty {
        origin: origin.to_owned(),
    })
}

/// The scalar values of one element, in the order of the header.
struct Scalars(Vec<f64>);

impl PropertyAccess for Scalars {
    fn new() -> Self {
        Self(Vec::new())
    }

    fn set_property(&mut self, _: &str, property: Property) {
        self.0.push(match property {
            Property::Char(v) => f64::from(v),
            Property::UChar(v) => f64::from(v),
            Property::Short(v) => f64::from(v),
            Property::UShort(v) => f64::from(v),
            Property::Int(v) => f64::from(v),
            Property::UInt(v) => f64::from(v),
            Property::Float(v) => f64::from(v),
            Property::Double(v) => v,
            // Lists keep their place; no column is one.
            _ => f64::NAN,
        });
    }
}

/// Reads one element; an error is what is wrong, in one line.
pub(crate) fn read_element<E: PropertyAccess>(
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
    read.map_err(|e| {
        let text = e.to_string();
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    })
}

/// The vertices read so far.
struct Vertices {
    means: Vec<[f32; 3]>,
    log_scales: Vec<[f32; 3]>,
    rotations: Vec<[f32; 4]>,
    opacities: Vec<f32>,
    sh: Vec<[f32; 3]>,
}

impl Vertices {
    /// `count` is safe to reserve: the file holds bytes for each vertex.
    fn new(columns: &Columns, count: usize) -> Self {
        Self {
            means: Vec::with_capacity(count),
            log_scales: Vec::with_capacity(count),
            rotations: Vec::with_capacity(count),
            opacities: Vec::with_capacity(count),
            sh: Vec::with_capacity(count.saturating_mul(sh::coefficients(columns.degree))),
        }
    }

    /// Takes one vertex; an error is the column of a value that is not finite.
    fn push(&mut self, columns: &Columns, values: &[f64]) -> Result<(), usize> {
        let get = |column: usize| -> Result<f32, usize> {
            let value = values.get(column).copied().unwrap_or(f64::NAN) as f32;
            if value.is_finite() {
                Ok(value)
            } else {
                Err(column)
            }
        };
        let three =
            |c: [usize; 3]| -> Result<[f32; 3], usize> { Ok([get(c[0])?, get(c[1])?, get(c[2])?]) };
        self.means.push(three(columns.mean)?);
        self.log_scales.push(three(columns.scale)?);
        let r = columns.rotation;
        self.rotations
            .push([get(r[0])?, get(r[1])?, get(r[2])?, get(r[3])?]);
        let opacity = values.get(columns.opacity).copied().unwrap_or(f64::NAN);
        if opacity.is_nan() {
            return Err(columns.opacity);
        }
        self.opacities.push(opacity as f32);
        self.sh.push(three(columns.constant)?);
        let rest = sh::coefficients(columns.degree) - 1;
        for c in 0..rest {
            let at = |channel: usize| columns.rest[channel * rest + c];
            self.sh.push(three([at(0), at(1), at(2)])?);
        }
        Ok(())
    }

    fn finish(self, columns: &Columns) -> Result<Cloud, CloudError> {
        Cloud::new(
            columns.degree,
            self.means,
            self.log_scales,
            self.rotations,
            self.opacities,
            self.sh,
        )
    }
}

#[cfg(test)]
mod tests;
