//! The `.compressed.ply` files of PlayCanvas.
//!
//! Element `chunk` holds the bounds of 256 Gaussians each: of centres, of log scales, and, except
//! in old files, of colours. Element `vertex` holds four 32-bit words a Gaussian: centre and log
//! scale as fractions of the bounds in 11, 10 and 11 bits from the top, the quaternion `w, x, y,
//! z` as the index of its largest component in 2 bits and the others in 10 bits each over
//! +-1/sqrt(2), and colour and opacity in 8 bits each. Without colour bounds a colour is a
//! fraction of 1. The optional element `sh` holds the coefficients above the constant,
//! channel-major, as bytes over -4 to 4. Sources: the PlayCanvas manual and the format's writer,
//! splat-transform.

use std::f64::consts::SQRT_2;

use ply_rs_bw::ply::{ElementDef, Encoding, Header as PlyHeader, PropertyType, ScalarType};

use super::error::{FileError, Origin};
use super::values;
use crate::Cloud;
use crate::file_content::{Facts, Loaded, Raw};
use crate::ply::{self, SAID, header_comments, with_other_models};
use potamoi_base::file_keys::{Fate, FileKeys, Format, Notes, key};
use potamoi_base::sh;
use potamoi_containers::ply::PlyFileError;
use potamoi_containers::ply::header::{self, Header, type_name};

/// Gaussians a chunk; the last may have fewer.
const CHUNK: usize = 256;
/// Properties of a chunk's bounds, the smallest values first.
const POSITIONS: [&str; 6] = ["min_x", "min_y", "min_z", "max_x", "max_y", "max_z"];
const SCALES: [&str; 6] = [
    "min_scale_x",
    "min_scale_y",
    "min_scale_z",
    "max_scale_x",
    "max_scale_y",
    "max_scale_z",
];
const COLOURS: [&str; 6] = ["min_r", "min_g", "min_b", "max_r", "max_g", "max_b"];
/// Properties of a vertex.
const WORDS: [&str; 4] = [
    "packed_position",
    "packed_rotation",
    "packed_scale",
    "packed_color",
];

/// Keys of the format: `element.property`.
pub static FORMAT: Format = Format {
    name: "packed PLY of PlayCanvas",
    files: "`.ply` with a property `packed_position`, such as `.compressed.ply`: `element.property`, and comments",
    keys: &with_other_models::<_, 35>([
        key(
            "chunk.min_*",
            Fate::Honoured,
            "smallest value in 256 Gaussians: x, y, z, scale_x, scale_y, scale_z and, but for old files, r, g, b; not above the largest",
        ),
        key("chunk.max_*", Fate::Honoured, "largest value"),
        key(
            "vertex.packed_position",
            Fate::Honoured,
            "fractions of the bounds in 11, 10 and 11 bits",
        ),
        key(
            "vertex.packed_rotation",
            Fate::Honoured,
            "three components of the quaternion in 10 bits each, and which is left out",
        ),
        key(
            "vertex.packed_scale",
            Fate::Honoured,
            "logarithms, as positions",
        ),
        key(
            "vertex.packed_color",
            Fate::Honoured,
            "colour and opacity in 8 bits each",
        ),
        key(
            "sh.f_rest_*",
            Fate::Honoured,
            "coefficients, channel by channel, as bytes over -4 to 4",
        ),
        key(
            "filter_3D",
            Fate::Refused,
            "the filter of Mip-Splatting is fused before packing; pack the file again",
        ),
        SAID[0],
        SAID[1],
        SAID[2],
        key("comment *", Fate::Listed, "any other"),
        key(
            "obj_info *",
            Fate::Listed,
            "but for what is a comment above",
        ),
        key(
            "bytes after *",
            Fate::Listed,
            "what follows the last element",
        ),
    ]),
    others: Fate::Listed,
};

/// Whether vertices are packed.
pub(super) fn is_packed(header: &PlyHeader) -> bool {
    let vertex = header.elements.get("vertex");
    vertex.is_some_and(|v| v.properties.contains_key("packed_position"))
}

/// Reads a cloud from a whole file; `origin` names it in errors.
///
/// # Errors
/// The file is not a complete packed PLY file.
pub fn parse(bytes: &[u8], origin: &str) -> Result<Loaded, FileError> {
    let header = header::read(&mut &*bytes, origin)?;
    Ok(decode(&header, &bytes[header.bytes..], origin)?.turned(None))
}

/// Reads a cloud from the bytes behind the header.
pub(super) fn decode(header: &Header, body: &[u8], origin: &str) -> Result<Raw, FileError> {
    let name = Origin(origin);
    let mut record = FileKeys::new(&FORMAT, entries(header));
    let says = header_comments::take(&mut record, origin)?;
    if header.ply.encoding != Encoding::BinaryLittleEndian {
        let value = header.ply.encoding.to_string();
        return Err(name.field("format", value, "binary_little_endian for packed vertices"));
    }
    let needed = header::least_bytes(&header.ply);
    if needed > body.len() as u128 {
        return Err(FileError::from(PlyFileError::Truncated {
            origin: origin.to_owned(),
            needed,
            found: body.len() as u64,
        }));
    }
    let vertices = Table::find(&header.ply, body, "vertex", name)?;
    let chunks = Table::find(&header.ply, body, "chunk", name)?;
    let count = vertices.count;
    if count == 0 {
        return Err(name.field("count of element `vertex`", 0, "at least 1"));
    }
    if chunks.count != count.div_ceil(CHUNK) {
        let expected = format!(
            "{}, one for {CHUNK} of {count} vertices",
            count.div_ceil(CHUNK)
        );
        return Err(name.field("count of element `chunk`", chunks.count, expected));
    }
    let bounds = |names: [&str; 6]| Bounds::read(&chunks, names, name);
    let position = bounds(POSITIONS)?;
    let scale = bounds(SCALES)?;
    let colour = if COLOURS.iter().any(|own| chunks.has(own)) {
        bounds(COLOURS)?
    } else {
        Bounds(vec![[0.0, 0.0, 0.0, 1.0, 1.0, 1.0]; chunks.count])
    };
    let word = |column: &str| vertices.column(column, &ScalarType::UInt, name);
    let [p, r, s, c] = WORDS.map(word);
    let [p, r, s, c] = [p?, r?, s?, c?];
    let (degree, rest) = harmonics(&header.ply, body, count, name)?;
    let mut notes = Notes::default();
    for own in POSITIONS.into_iter().chain(SCALES).chain(COLOURS) {
        record.take(&format!("chunk.{own}"));
    }
    for own in WORDS {
        record.take(&format!("vertex.{own}"));
    }
    for i in 0..3 * (sh::coefficients(degree) - 1) {
        record.take(&format!("sh.f_rest_{i}"));
    }
    record.finish(&mut notes).map_err(|e| name.key(e))?;
    // All elements but lists, which are refused, are as long as this.
    let left = (body.len() as u128).saturating_sub(needed);
    if left > 0 {
        notes.list(format!("bytes after the last element ({left})"));
    }
    let each = sh::coefficients(degree) - 1;
    let logits = values::logits();
    let fractions = |i: usize, at: usize| {
        let word = vertices.word(i, at);
        [bits(word, 21, 11), bits(word, 11, 10), bits(word, 0, 11)]
    };
    let cloud = Cloud::new(
        degree,
        values::each(count, |i| position.at(i, fractions(i, p)).map(|v| v as f32)),
        values::each(count, |i| scale.at(i, fractions(i, s)).map(|v| v as f32)),
        values::each(count, |i| rotation(vertices.word(i, r))),
        values::each(count, |i| logits[(vertices.word(i, c) & 255) as usize]),
        values::coefficients(count, degree, |i, out| {
            let word = vertices.word(i, c);
            let fractions = [bits(word, 24, 8), bits(word, 16, 8), bits(word, 8, 8)];
            out[0] = colour.at(i, fractions).map(values::constant);
            if let Some((table, columns)) = &rest {
                for (k, out) in out[1..].iter_mut().enumerate() {
                    *out = [0, 1, 2].map(|ch| harmonic(table.byte(i, columns[ch * each + k])));
                }
            }
        }),
    )
    .map_err(|e| name.cloud(e))?;
    let mut facts = Facts::of(&FORMAT);
    facts.say("chunks", chunks.count);
    facts.generator = header_comments::generator(&header.ply);
    Ok(Raw {
        up: says.up,
        ..Raw::new(cloud.antialiased(says.antialiased), notes).with(facts)
    })
}

/// `element.property` of each property; properties of other models have only their own name.
fn entries(header: &Header) -> Vec<(String, String)> {
    let of_others = |property: &str| {
        let row = ply::FORMAT.row(property);
        property == "filter_3D" || row.is_some_and(|own| own.fate == Fate::Refused)
    };
    let elements = header.ply.elements.iter();
    let properties = elements.flat_map(|(name, element)| {
        element.properties.keys().map(move |property| {
            let key = match name == "vertex" && of_others(property) {
                true => property.clone(),
                false => format!("{name}.{property}"),
            };
            (key, String::new())
        })
    });
    properties
        .chain(header_comments::entries(&header.ply))
        .collect()
}

/// The `width` bits from `low` on, as a fraction of their largest value.
fn bits(word: u32, low: u32, width: u32) -> f64 {
    let most = (1u32 << width) - 1;
    f64::from(word >> low & most) / f64::from(most)
}

fn rotation(word: u32) -> [f32; 4] {
    let others = [20, 10, 0].map(|low| (bits(word, low, 10) - 0.5) * SQRT_2);
    values::with_largest((word >> 30) as usize, others)
}

/// The coefficient of a code. The writer truncates, so codes mean the middle of their step, except
/// the first and the last.
fn harmonic(code: u8) -> f32 {
    match code {
        0 => -4.0,
        255 => 4.0,
        _ => (f32::from(code) + 0.5) / 32.0 - 4.0,
    }
}

type Harmonics<'a> = (usize, Option<(Table<'a>, Vec<usize>)>);

/// The degree, and the columns of element `sh`, if present.
fn harmonics<'a>(
    header: &'a PlyHeader,
    body: &'a [u8],
    count: usize,
    name: Origin<'_>,
) -> Result<Harmonics<'a>, FileError> {
    if !header.elements.contains_key("sh") {
        return Ok((0, None));
    }
    let table = Table::find(header, body, "sh", name)?;
    if table.count != count {
        let expected = format!("{count}, as of element `vertex`");
        return Err(name.field("count of element `sh`", table.count, expected));
    }
    let found = table.element.properties.len();
    let degree = (1..=sh::MAX_DEGREE)
        .find(|d| 3 * (sh::coefficients(*d) - 1) == found)
        .ok_or_else(|| {
            let expected = "9, 24 or 45 (spherical harmonics of degree 1, 2 or 3)";
            name.field("number of properties of element `sh`", found, expected)
        })?;
    let columns = (0..found)
        .map(|i| table.column(&format!("f_rest_{i}"), &ScalarType::UChar, name))
        .collect::<Result<_, _>>()?;
    Ok((degree, Some((table, columns))))
}

/// Smallest and largest values, three each, for every chunk.
struct Bounds(Vec<[f32; 6]>);

impl Bounds {
    fn read(chunks: &Table<'_>, names: [&str; 6], name: Origin<'_>) -> Result<Self, FileError> {
        let mut all = vec![[0.0; 6]; chunks.count];
        for (k, property) in names.into_iter().enumerate() {
            let column = chunks.column(property, &ScalarType::Float, name)?;
            for (i, bounds) in all.iter_mut().enumerate() {
                bounds[k] = f32::from_bits(chunks.word(i, column));
                if !bounds[k].is_finite() {
                    let field = format!("chunk {i}, property `{property}`");
                    return Err(name.field(field, bounds[k], "a finite number"));
                }
                if k >= 3 && bounds[k] < bounds[k - 3] {
                    let field = format!("chunk {i}, property `{property}`");
                    let expected = format!("at least its `{}`, {}", names[k - 3], bounds[k - 3]);
                    return Err(name.field(field, bounds[k], expected));
                }
            }
        }
        Ok(Self(all))
    }

    /// The values of Gaussian `i`, from their fractions of its chunk's bounds.
    fn at(&self, i: usize, fractions: [f64; 3]) -> [f64; 3] {
        let bounds = &self.0[i / CHUNK];
        [0, 1, 2].map(|k| {
            let [low, high] = [bounds[k], bounds[k + 3]].map(f64::from);
            low * (1.0 - fractions[k]) + high * fractions[k]
        })
    }
}

/// The rows of an element that has only scalars.
struct Table<'a> {
    name: &'a str,
    element: &'a ElementDef,
    rows: &'a [u8],
    stride: usize,
    count: usize,
}

impl<'a> Table<'a> {
    /// Finds an element's rows in a body that holds all elements completely.
    fn find(
        header: &'a PlyHeader,
        body: &'a [u8],
        wanted: &str,
        origin: Origin<'_>,
    ) -> Result<Self, FileError> {
        let mut rows = body;
        for (name, element) in &header.elements {
            let mut stride = 0;
            for (property, definition) in &element.properties {
                match &definition.data_type {
                    PropertyType::Scalar(scalar) => stride += header::scalar_bytes(scalar) as usize,
                    PropertyType::List(..) => {
                        let field = format!("element `{name}`: property `{property}`");
                        return Err(origin.field(field, "a list", "a scalar"));
                    }
                }
            }
            let all = stride.saturating_mul(element.count).min(rows.len());
            if name == wanted {
                return Ok(Self {
                    name,
                    element,
                    rows: &rows[..all],
                    stride,
                    count: element.count,
                });
            }
            rows = &rows[all..];
        }
        let expected = "one: packed vertices need their chunks' bounds";
        Err(origin.field(format!("element `{wanted}`"), "missing", expected))
    }

    fn has(&self, property: &str) -> bool {
        self.element.properties.contains_key(property)
    }

    /// The position of a property within a row.
    fn column(
        &self,
        wanted: &str,
        wanted_type: &ScalarType,
        origin: Origin<'_>,
    ) -> Result<usize, FileError> {
        let mut at = 0;
        let field = || format!("element `{}`: property `{wanted}`", self.name);
        for (property, definition) in &self.element.properties {
            if let PropertyType::Scalar(scalar) = &definition.data_type {
                if property == wanted {
                    if scalar != wanted_type {
                        let [found, expected] = [scalar, wanted_type].map(type_name);
                        return Err(origin.field(field(), found, expected));
                    }
                    return Ok(at);
                }
                at += header::scalar_bytes(scalar) as usize;
            }
        }
        Err(origin.field(field(), "missing", type_name(wanted_type)))
    }

    fn byte(&self, row: usize, at: usize) -> u8 {
        self.rows[row * self.stride + at]
    }

    fn word(&self, row: usize, at: usize) -> u32 {
        let start = row * self.stride + at;
        let b = &self.rows[start..start + 4];
        u32::from_le_bytes([b[0], b[1], b[2], b[3]])
    }
}
