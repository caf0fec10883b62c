//! The PLY files of 3D Gaussian splatting.
//!
//! Properties are found by name, in any order: `x y z`, `f_dc_0..2`, `f_rest_*` (channel-major, 0,
//! 9, 24 or 45 of them for degrees 0 to 3), `opacity` (a logit), `scale_0..2` (logarithms),
//! `rot_0..3` (`w, x, y, z`), and `filter_3D` of Mip-Splatting, which is fused into sizes and
//! opacities. Other properties, such as normals, are listed as unused. Without `scale_2` Gaussians
//! are the discs of 2DGS, drawn as Gaussians of no thickness. Binary files of either byte order
//! and text files with any line ends are read.

mod centres;
mod columns;
pub(super) mod header_comments;
pub(super) mod other_models;
mod vertices;

use std::io::BufRead;
use std::path::Path;

use ply_rs_bw::ply::ElementDef;
use thiserror::Error;

use super::cloud::CloudError;
use super::file_content::{Facts, Loaded, Raw};
use columns::Columns;
pub(super) use other_models::with_other_models;
use potamoi_base::file_keys::{Fate, FileKeys, Format, Key, KeyError, Notes, key};
use potamoi_containers::ply::header::{self, Header};
use potamoi_containers::ply::rows::{ENDS_WITHIN, FixedRow, Layout, Rows};
use potamoi_containers::ply::{PlyFileError, open};
use vertices::Vertices;

/// Keys of comments, which packed files share.
pub(super) const SAID: [Key; 3] = [
    key(
        header_comments::RENDER_MODE,
        Fate::Honoured,
        "`mip`: trained with antialiasing; `default`: not",
    ),
    key(
        header_comments::ANTIALIASED,
        Fate::Honoured,
        "1: trained with antialiasing; 0: not",
    ),
    key(
        header_comments::VERTICAL_AXIS,
        Fate::Honoured,
        "x, y or z, with a sign: up in the default view and in orbits; anything else is listed",
    ),
];
/// Keys of the format. Its properties are those of element `vertex`.
pub static FORMAT: Format = Format {
    name: "PLY of 3D Gaussian splatting",
    files: "`.ply`: properties of element `vertex`, comments and other elements",
    keys: &with_other_models::<_, 47>([
        key(
            "x",
            Fate::Honoured,
            "centre; of `double`s far from the origin, their median is subtracted first",
        ),
        key("y", Fate::Honoured, "the same"),
        key("z", Fate::Honoured, "the same"),
        key("f_dc_0", Fate::Honoured, "the constant coefficient of red"),
        key("f_dc_1", Fate::Honoured, "of green"),
        key("f_dc_2", Fate::Honoured, "of blue"),
        key(
            "f_rest_*",
            Fate::Honoured,
            "the other coefficients, channel by channel: 0, 9, 24 or 45",
        ),
        key(
            "opacity",
            Fate::Honoured,
            "before the sigmoid; may be infinite",
        ),
        key(
            "scale_0",
            Fate::Honoured,
            "logarithms of sizes; minus infinity is a size of 0",
        ),
        key("scale_1", Fate::Honoured, "the same"),
        key(
            "scale_2",
            Fate::Honoured,
            "the same; without it, 2DGS, drawn as discs of no thickness",
        ),
        key(
            "rot_0",
            Fate::Honoured,
            "the quaternion w, x, y, z, of any length; of length 0 it is no rotation",
        ),
        key("rot_1", Fate::Honoured, "the same"),
        key("rot_2", Fate::Honoured, "the same"),
        key("rot_3", Fate::Honoured, "the same"),
        key(
            "filter_3D",
            Fate::Honoured,
            "the filter of Mip-Splatting: fused into sizes and opacities",
        ),
        key("nx", Fate::Listed, "normals, which Gaussians have none of"),
        key("ny", Fate::Listed, "the same"),
        key("nz", Fate::Listed, "the same"),
        SAID[0],
        SAID[1],
        SAID[2],
        key("comment *", Fate::Listed, "any other"),
        key(
            "obj_info *",
            Fate::Listed,
            "but for what is a comment above",
        ),
        key("element *", Fate::Listed, "other elements are read past"),
        key(
            "bytes after *",
            Fate::Listed,
            "what follows the last element",
        ),
    ]),
    others: Fate::Listed,
};

/// A PLY file from which no cloud can be read.
#[derive(Debug, Error)]
pub enum PlyError {
    /// The container cannot be read.
    #[error(transparent)]
    File(#[from] PlyFileError),
    /// A required property is missing.
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
    /// A property has the wrong type.
    #[error(
        "{origin}: element `vertex`, property `{property}` is {found}: expected float or double; \
         the meaning of codes of other types is not in the file: write the file again with float"
    )]
    Type {
        /// The file.
        origin: String,
        /// The property.
        property: String,
        /// Its type.
        found: &'static str,
    },
    /// A comment has an invalid value.
    #[error("{origin}: {message}")]
    Comment {
        /// The file.
        origin: String,
        /// The comment, its value and the allowed values.
        message: String,
    },
    /// The file has a feature that is not supported.
    #[error("{origin}: {source}")]
    Key {
        /// The file.
        origin: String,
        /// The feature, and why it is refused.
        source: Box<KeyError>,
    },
    /// The number of `f_rest_*` properties fits no degree.
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
    /// The file has no vertices.
    #[error("{origin}: no Gaussian: element `vertex` must hold at least one")]
    Empty {
        /// The file.
        origin: String,
    },
    /// A value is NaN, infinite or beyond 32 bits where this is not allowed.
    #[error(
        "{origin}: vertex {index}, property `{property}` is {value:?}: \
         expected a finite number from -3.4e38 to 3.4e38 (`opacity` may be infinite, sizes minus infinity; \
         `filter_3D` is not negative)"
    )]
    NotFinite {
        /// The file.
        origin: String,
        /// Index of the vertex, from 0.
        index: usize,
        /// The property.
        property: String,
        /// The value.
        value: f64,
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

/// Reads a PLY file of 3D Gaussian splatting.
///
/// # Errors
/// The file cannot be read, is incomplete or of another kind, or has values that are not finite.
pub fn read(path: &Path) -> Result<Loaded, PlyError> {
    let (reader, length) = open(path)?;
    parse(reader, length, &path.display().to_string())
}

/// Reads a cloud from `length` bytes; `origin` names them in errors.
///
/// # Errors
/// Those of [`read`].
pub fn parse(
    mut reader: impl BufRead + Send,
    length: u64,
    origin: &str,
) -> Result<Loaded, PlyError> {
    let header = header::read(&mut reader, origin)?;
    Ok(body(&header, reader, length, origin)?.turned(None))
}

/// Reads the part behind the header, of a file of `length` bytes.
pub(super) fn body(
    header: &Header,
    reader: impl BufRead + Send,
    length: u64,
    origin: &str,
) -> Result<Raw, PlyError> {
    let found = length.saturating_sub(header.bytes as u64);
    let mut record = FileKeys::new(&FORMAT, entries(header));
    let columns = Columns::take(&header.ply, &mut record, origin)?;
    let says = header_comments::take(&mut record, origin)?;
    let mut notes = Notes::default();
    if columns.scale[2].is_none() {
        notes.assume("2DGS: discs, drawn as Gaussians of no thickness");
    }
    record.finish(&mut notes).map_err(|source| PlyError::Key {
        origin: origin.to_owned(),
        source: source.into(),
    })?;
    let needed = header::least_bytes(&header.ply);
    if needed > u128::from(found) {
        return Err(PlyFileError::Truncated {
            origin: origin.to_owned(),
            needed,
            found,
        }
        .into());
    }
    let mut rows = Rows::new(reader, header);
    let mut values = vec![];
    let mut vertices = None;
    for (name, element) in &header.ply.elements {
        let layout = Layout::of(element);
        if name == "vertex" {
            let source = Source { element, origin };
            vertices = Some(match rows.fixed(&layout) {
                Some(row) => source.by_stride(&mut rows, &row, &columns)?,
                None => source.row_by_row(&mut rows, &layout, &columns)?,
            });
            continue;
        }
        for index in 0..element.count {
            (rows.read(&layout, &mut values)).map_err(|message| PlyFileError::Element {
                origin: origin.to_owned(),
                element: name.clone(),
                index,
                message,
            })?;
        }
    }
    let left = rows.rest().map_err(|e| PlyFileError::Header {
        origin: origin.to_owned(),
        message: e.to_string(),
    })?;
    if left > 0 {
        notes.list(format!("bytes after the last element ({left})"));
    }
    let vertices = vertices.ok_or_else(|| PlyError::Empty {
        origin: origin.to_owned(),
    })?;
    let (cloud, middle, rounded) = vertices
        .finish(&columns)
        .map_err(|source| PlyError::Cloud {
            origin: origin.to_owned(),
            source,
        })?;
    if middle != glam::DVec3::ZERO {
        let [x, y, z] = middle.to_array();
        notes.assume(format!(
            "centres from ({x}, {y}, {z}) on, which floats do not hold"
        ));
    }
    if let Some(own) = rounded {
        notes.list(format!(
            "the last digits of {} centres, which floats move by up to {:.1e}",
            own.count, own.most
        ));
    }
    let mut facts = Facts::of(&FORMAT);
    facts.say("encoding", header.ply.encoding);
    facts.generator = header_comments::generator(&header.ply);
    if columns.filter.is_some() {
        facts.say("filter of Mip-Splatting", "fused into sizes and opacities");
    }
    if columns.scale[2].is_none() {
        facts.say("thickness", "none: the discs of 2DGS");
    }
    Ok(Raw {
        origin: middle,
        up: says.up,
        ..Raw::new(cloud.antialiased(says.antialiased), notes).with(facts)
    })
}

/// Keys of vertex properties, other elements and comments.
fn entries(header: &Header) -> Vec<(String, String)> {
    let mut all = vec![];
    for (name, element) in &header.ply.elements {
        if name != "vertex" {
            all.push((format!("element {name}"), String::new()));
            continue;
        }
        all.extend(
            element
                .properties
                .keys()
                .map(|own| (own.clone(), String::new())),
        );
    }
    all.extend(header_comments::entries(&header.ply));
    all
}

/// Bytes of vertices that are read at once.
const AT_ONCE: usize = 1 << 21;

/// The vertices of a file.
struct Source<'a> {
    element: &'a ElementDef,
    /// Names the file in errors.
    origin: &'a str,
}

impl Source<'_> {
    /// Reads rows of one length: the next ones while threads take those before.
    fn by_stride(
        &self,
        rows: &mut Rows<impl BufRead + Send>,
        row: &FixedRow,
        columns: &Columns,
    ) -> Result<Vertices, PlyError> {
        let count = self.element.count;
        let mut vertices = Vertices::new(columns, count);
        let most = (AT_ONCE / row.stride).max(1);
        let [mut bytes, mut next] = [vec![], vec![]];
        let (mut start, mut asked) = (0, most.min(count));
        let mut read = rows.read_many(row.stride, asked, &mut bytes);
        while start < count {
            let done = read.clone();
            let following = most.min(count - start - asked);
            let taken;
            (read, taken) = rayon::join(
                || rows.read_many(row.stride, following, &mut next),
                || vertices.extend(columns, row, &bytes),
            );
            // What is wrong with the first vertex is told first.
            if let Err((at, column)) = taken {
                let own = &bytes[at * row.stride..];
                return Err(self.not_finite(start + at, column, row.value(own, column)));
            }
            let found = bytes.len() / row.stride;
            if let Err(message) = done {
                return Err(self.wrong(start + found, message));
            }
            if found < asked {
                return Err(self.wrong(start + found, ENDS_WITHIN.to_owned()));
            }
            start += asked;
            asked = following;
            std::mem::swap(&mut bytes, &mut next);
        }
        Ok(vertices)
    }

    /// Reads text, and rows with lists.
    fn row_by_row(
        &self,
        rows: &mut Rows<impl BufRead>,
        layout: &Layout,
        columns: &Columns,
    ) -> Result<Vertices, PlyError> {
        let mut vertices = Vertices::new(columns, self.element.count);
        let mut values = vec![];
        for index in 0..self.element.count {
            (rows.read(layout, &mut values)).map_err(|message| self.wrong(index, message))?;
            vertices.push(columns, &values).map_err(|column| {
                let value = values.get(column).copied().unwrap_or(f64::NAN);
                self.not_finite(index, column, value)
            })?;
        }
        Ok(vertices)
    }

    /// An error of a whole row.
    fn wrong(&self, index: usize, message: String) -> PlyError {
        let error = PlyFileError::Element {
            origin: self.origin.to_owned(),
            element: "vertex".to_owned(),
            index,
            message,
        };
        error.into()
    }

    fn not_finite(&self, index: usize, column: usize, value: f64) -> PlyError {
        let property = self.element.properties.get_index(column);
        PlyError::NotFinite {
            origin: self.origin.to_owned(),
            index,
            property: property.map_or_else(String::new, |(name, _)| name.clone()),
            value,
        }
    }
}

#[cfg(test)]
mod tests;
