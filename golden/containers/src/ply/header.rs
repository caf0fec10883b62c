//! The header of a PLY file, checked before the elements are read.

use std::io::{BufRead, Read};

use ply_rs_bw::ply::{
    ElementDef, Encoding, Header as PlyHeader, PropertyDef, PropertyType, ScalarType,
};

use super::PlyFileError;
use potamoi_base::file_keys::told;

/// The longest header, in bytes.
const LIMIT: usize = 1 << 24;
/// Maximum length of a line in messages, in characters.
const SHOWN: usize = 60;
/// The byte order mark that some editors prepend.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
/// The types of properties, each with its two names.
const TYPES: [(&str, &str, ScalarType); 8] = [
    ("char", "int8", ScalarType::Char),
    ("uchar", "uint8", ScalarType::UChar),
    ("short", "int16", ScalarType::Short),
    ("ushort", "uint16", ScalarType::UShort),
    ("int", "int32", ScalarType::Int),
    ("uint", "uint32", ScalarType::UInt),
    ("float", "float32", ScalarType::Float),
    ("double", "float64", ScalarType::Double),
];

/// A header and its length.
pub struct Header {
    /// Elements and their properties.
    pub ply: PlyHeader,
    /// Bytes from the start of the file to the end of the header.
    pub bytes: usize,
    /// Line end: a line feed, or a single carriage return.
    pub(crate) line_end: u8,
}

/// Reads up to and including `end_header`.
pub fn read(reader: &mut impl BufRead, origin: &str) -> Result<Header, PlyFileError> {
    let fail = |message: String| PlyFileError::Header {
        origin: origin.to_owned(),
        message,
    };
    let (mut bytes, line_end) = first_line(reader, origin)?;
    let mut parts = Parts::default();
    let mut line = Vec::new();
    for number in 2.. {
        line.clear();
        let room = (LIMIT - bytes) as u64;
        let read = (reader.by_ref().take(room))
            .read_until(line_end, &mut line)
            .map_err(|e| fail(e.to_string()))?;
        if read == 0 || line.last() != Some(&line_end) {
            return Err(PlyFileError::NoHeaderEnd {
                origin: origin.to_owned(),
                limit: LIMIT,
            });
        }
        bytes += read;
        let line = text(&line);
        if line.trim() == "end_header" {
            break;
        }
        (parts.line(line.trim())).map_err(|message| {
            let shown: String = line.trim().chars().take(SHOWN).collect();
            fail(format!("line {number}: `{shown}`: {message}"))
        })?;
    }
    Ok(Header {
        ply: parts.finish().map_err(fail)?,
        bytes,
        line_end,
    })
}

/// Decodes a comment of any encoding: UTF-8, or else Latin-1, in which every byte is a character.
fn text(line: &[u8]) -> String {
    std::str::from_utf8(line).map_or_else(
        |_| line.iter().map(|byte| char::from(*byte)).collect(),
        str::to_owned,
    )
}

/// Reads `ply` and returns its number of bytes and the line end.
fn first_line(reader: &mut impl BufRead, origin: &str) -> Result<(usize, u8), PlyFileError> {
    let not_ply = || PlyFileError::NotPly {
        origin: origin.to_owned(),
    };
    let mut line = vec![];
    for byte in reader.by_ref().take(64).bytes() {
        let byte = byte.map_err(|_| not_ply())?;
        line.push(byte);
        if byte == b'\n' || byte == b'\r' {
            break;
        }
    }
    let start = line.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&line);
    let Some((end, word)) = start.split_last() else {
        return Err(not_ply());
    };
    if word.trim_ascii_end() != b"ply" {
        return Err(not_ply());
    }
    if *end == b'\n' {
        return Ok((line.len(), b'\n'));
    }
    let follows = reader.fill_buf().map_err(|_| not_ply())?;
    if follows.first() == Some(&b'\n') {
        reader.consume(1);
        return Ok((line.len() + 1, b'\n'));
    }
    Ok((line.len(), b'\r'))
}

/// The declarations read so far.
#[derive(Default)]
struct Parts {
    ply: PlyHeader,
    has_format: bool,
    element: Option<ElementDef>,
}

impl Parts {
    /// Processes a line; the error says what is wrong with it.
    fn line(&mut self, line: &str) -> Result<(), String> {
        let (word, rest) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let words: Vec<&str> = rest.split_whitespace().collect();
        match (word, &words[..]) {
            ("", _) => Ok(()),
            ("comment", _) => {
                self.ply.comments.push(rest.trim().to_owned());
                Ok(())
            }
            ("obj_info", _) => {
                self.ply.obj_infos.push(rest.trim().to_owned());
                Ok(())
            }
            ("format", [encoding, "1.0"]) if !self.has_format => {
                let known = [
                    Encoding::Ascii,
                    Encoding::BinaryLittleEndian,
                    Encoding::BinaryBigEndian,
                ];
                let found = known.into_iter().find(|own| own.to_string() == *encoding);
                self.ply.encoding = found.ok_or(
                    "expected format ascii, binary_little_endian or binary_big_endian, and 1.0",
                )?;
                self.has_format = true;
                Ok(())
            }
            ("format", _) => Err("expected one format, of version 1.0".to_owned()),
            ("element", [name, count]) => {
                self.close();
                if self.ply.elements.contains_key(*name) {
                    return Err(format!("a second element `{name}`"));
                }
                let mut element = ElementDef::new((*name).to_owned());
                element.count = (count.parse()).map_err(|_| {
                    format!("a count of `{count}`: expected a whole number, and not a negative one")
                })?;
                self.element = Some(element);
                Ok(())
            }
            ("element", _) => Err("expected element, a name and a count".to_owned()),
            ("property", words) => self.property(words),
            _ => Err(
                "expected format, comment, obj_info, element, property or end_header".to_owned(),
            ),
        }
    }

    fn property(&mut self, words: &[&str]) -> Result<(), String> {
        let Some(element) = &mut self.element else {
            return Err("expected it after an element".to_owned());
        };
        let (name, data_type) = match words {
            ["list", count, item, name] => {
                let count = scalar(count)?;
                if matches!(count, ScalarType::Float | ScalarType::Double) {
                    return Err("expected a list's length to be of a whole type".to_owned());
                }
                (name, PropertyType::List(count, scalar(item)?))
            }
            [kind, name] => (name, PropertyType::Scalar(scalar(kind)?)),
            _ => return Err("expected property, a type and a name".to_owned()),
        };
        if element.properties.contains_key(*name) {
            return Err(format!("a second property `{}`", told(name)));
        }
        let name = (*name).to_owned();
        let property = PropertyDef {
            name: name.clone(),
            data_type,
        };
        element.properties.insert(name, property);
        Ok(())
    }

    fn close(&mut self) {
        if let Some(element) = self.element.take() {
            self.ply.elements.insert(element.name.clone(), element);
        }
    }

    fn finish(mut self) -> Result<PlyHeader, String> {
        self.close();
        if !self.has_format {
            return Err("no line `format`: expected one, such as `format ascii 1.0`".to_owned());
        }
        // Nothing in the file would bound their number.
        let mut elements = self.ply.elements.iter();
        if let Some((name, _)) = elements.find(|(_, e)| e.properties.is_empty() && e.count > 0) {
            return Err(format!("element `{name}` has no property"));
        }
        Ok(self.ply)
    }
}

fn scalar(word: &str) -> Result<ScalarType, String> {
    let mut types = TYPES.into_iter();
    let found = types.find(|(name, other, _)| [*name, *other].contains(&word));
    found.map(|(_, _, kind)| kind).ok_or_else(|| {
        let halves = ["half", "float16"].contains(&word);
        let names = TYPES.map(|(name, _, _)| name).join(", ");
        let what = match halves {
            true => ": PLY has no floats of 16 bits; write the file again with float",
            false => "",
        };
        format!("type `{word}`: expected {names}{what}")
    })
}

/// The type's name in headers.
pub fn type_name(scalar: &ScalarType) -> &'static str {
    let mut types = TYPES.iter();
    let found = types.find(|(_, _, kind)| kind == scalar);
    found.map_or("", |(name, _, _)| *name)
}

/// Size of a number in binary files, in bytes.
pub const fn scalar_bytes(scalar: &ScalarType) -> u128 {
    match scalar {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// Minimum size of the declared elements in bytes.
pub fn least_bytes(header: &PlyHeader) -> u128 {
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
