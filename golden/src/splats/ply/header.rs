//! The header of a PLY file, checked before anything is read by it.

use std::collections::BTreeSet;
use std::io::{BufRead, Read};

use ply_rs_bw::parser::Parser;
use ply_rs_bw::ply::{
    DefaultElement, ElementDef, Encoding, Header as PlyHeader, PropertyType, ScalarType,
};

use super::PlyError;
use crate::splats::sh;

/// The longest header, in bytes.
const LIMIT: usize = 1 << 16;

/// A header and the bytes it took.
pub(crate) struct Header {
    pub(crate) ply: PlyHeader,
    pub(crate) bytes: usize,
}

/// Reads up to and including `end_header`.
pub(crate) fn read(reader: &mut impl BufRead, origin: &str) -> Result<Header, PlyError> {
    let wrong = |message: String| PlyError::Header {
        origin: origin.to_owned(),
        message,
    };
    let mut text = Vec::new();
    loop {
        let start = text.len();
        let room = (LIMIT - start) as u64;
        let read = reader
            .by_ref()
            .take(room)
            .read_until(b'\n', &mut text)
            .map_err(|e| wrong(e.to_string()))?;
        let line = text[start..].trim_ascii_end();
        if start == 0 && line != b"ply" {
            return Err(PlyError::NotPly {
                origin: origin.to_owned(),
            });
        }
        if line == b"end_header" && text.ends_with(b"\n") {
            break;
        }
        if read == 0 || !text.ends_with(b"\n") {
            return Err(PlyError::NoHeaderEnd {
                origin: origin.to_owned(),
                limit: LIMIT,
            });
        }
    }
    let words = std::str::from_utf8(&text).map_err(|_| wrong("not UTF-8 text".to_owned()))?;
    refuse_duplicates(words).map_err(wrong)?;
    let ply = Parser::<DefaultElement>::new()
        .read_header(&mut text.as_slice())
        .map_err(|e| {
            let message = e.to_string();
            wrong(message.split_whitespace().collect::<Vec<_>>().join(" "))
        })?;
    // Nothing in the file would bound their number.
    if let Some((name, _)) = ply
        .elements
        .iter()
        .find(|(_, e)| e.properties.is_empty() && e.count > 0)
    {
        return Err(wrong(format!("element `{name}` has no property")));
    }
    Ok(Header {
        ply,
        bytes: text.len(),
    })
}

/// The parser keeps the last of two namesakes and so loses count of columns.
fn refuse_duplicates(text: &str) -> Result<(), String> {
    let mut elements = BTreeSet::new();
    let mut properties = BTreeSet::new();
    for (number, line) in text.lines().enumerate() {
        let mut words = line.split_whitespace();
        let (first, last) = (words.next(), words.next_back());
        match (first, last) {
            (Some("element"), _) => {
                let name = line.split_whitespace().nth(1).unwrap_or_default();
                properties.clear();
                if !elements.insert(name) {
                    return Err(format!("line {}: a second element `{name}`", number + 1));
                }
            }
            (Some("property"), Some(name)) => {
                let new = properties.insert(name);
                if !new {
                    return Err(format!("line {}: a second property `{name}`", number + 1));
                }
            }
            _ => {}
        }
    }
    Ok(())
}

pub(in crate::splats) const fn scalar_bytes(scalar: &ScalarType) -> u128 {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// The bytes that the declared elements take at least.
pub(crate) fn least_bytes(header: &PlyHeader) -> u128 {
    let of_element = |element: &ElementDef| -> u128 {
        match header.encoding {
            // A digit and a separator each; the last line may lack its end.
            Encoding::Ascii => (2 * element.properties.len() as u128).max(1),
            _ => element
                .properties
                .iter()
                .map(|(_, p)| match &p.data_type {
                    PropertyType::Scalar(s) | PropertyType::List(s, _) => scalar_bytes(s),
                })
                .sum(),
        }
    };
    let sum: u128 = header
        .elements
        .iter()
        .map(|(_, e)| of_element(e) * e.count as u128)
        .sum();
    match header.encoding {
        Encoding::Ascii => sum.saturating_sub(1),
        _ => sum,
    }
}

/// Which column of a vertex holds what.
pub(super) struct Columns {
    pub(super) degree: usize,
    pub(super) mean: [usize; 3],
    pub(super) scale: [usize; 3],
    pub(super) rotation: [usize; 4],
    pub(super) opacity: usize,
    pub(super) constant: [usize; 3],
    /// Channel-major: all of red, then green, then blue.
    pub(super) rest: Vec<usize>,
}

impl Columns {
    /// Finds every property that a Gaussian needs.
    pub(super) fn find(header: &PlyHeader, origin: &str) -> Result<Self, PlyError> {
        let empty = || PlyError::Empty {
            origin: origin.to_owned(),
        };
        let vertex = header.elements.get("vertex").ok_or_else(empty)?;
        if vertex.count == 0 {
            return Err(empty());
        }
        let column = |name: &str| -> Result<usize, PlyError> {
            match vertex.properties.get_full(name) {
                Some((i, _, p)) if matches!(p.data_type, PropertyType::Scalar(_)) => Ok(i),
                Some(_) => Err(PlyError::Header {
                    origin: origin.to_owned(),
                    message: format!("property `{name}` is a list: expected a scalar"),
                }),
                None => Err(PlyError::Missing {
                    origin: origin.to_owned(),
                    property: name.to_owned(),
                }),
            }
        };
        let found = vertex
            .properties
            .keys()
            .filter(|name| name.starts_with("f_rest_"))
            .count();
        let degree = (0..=sh::MAX_DEGREE)
            .find(|d| 3 * (sh::coefficients(*d) - 1) == found)
            .ok_or_else(|| PlyError::Degree {
                origin: origin.to_owned(),
                found,
            })?;
        Ok(Self {
            degree,
            mean: [column("x")?, column("y")?, column("z")?],
            constant: [column("f_dc_0")?, column("f_dc_1")?, column("f_dc_2")?],
            rest: (0..found)
                .map(|i| column(&format!("f_rest_{i}")))
                .collect::<Result<_, _>>()?,
            opacity: column("opacity")?,
            scale: [column("scale_0")?, column("scale_1")?, column("scale_2")?],
            rotation: [
                column("rot_0")?,
                column("rot_1")?,
                column("rot_2")?,
                column("rot_3")?,
            ],
        })
    }
}
