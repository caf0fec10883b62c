//! The chunks of a `.glb` file.

use super::super::bytes::u32;
use super::super::error::{FileError, Origin};
use potamoi_base::file_keys::told;

/// What a `.glb` file begins with.
const MAGIC: &[u8] = b"glTF";
/// Bytes of the header, and of that of a chunk.
const HEADER: usize = 12;
const CHUNK: usize = 8;
/// Types of chunks.
const JSON: u32 = 0x4e4f_534a;
const BINARY: u32 = 0x004e_4942;

/// The parts of a glTF file.
#[derive(Debug)]
pub(super) struct Parts<'a> {
    /// The JSON text.
    pub(super) json: &'a [u8],
    /// The buffer without a name.
    pub(super) binary: Option<&'a [u8]>,
    /// Keys of the chunks of other kinds.
    pub(super) beside: Vec<String>,
}

impl<'a> Parts<'a> {
    /// Splits a file; one that is no `.glb` is all JSON.
    pub(super) fn of(bytes: &'a [u8], name: Origin<'_>) -> Result<Self, FileError> {
        let mut parts = Parts {
            json: bytes,
            binary: None,
            beside: vec![],
        };
        if !bytes.starts_with(MAGIC) {
            return Ok(parts);
        }
        if bytes.len() < HEADER + CHUNK {
            let expected = format!("at least the {} of two headers", HEADER + CHUNK);
            return Err(name.field("length in bytes", bytes.len(), expected));
        }
        let (version, length) = (u32(bytes, 4), u32(bytes, 8) as usize);
        if version != 2 {
            return Err(name.field("version of the container", version, "2"));
        }
        if !(HEADER + CHUNK..=bytes.len()).contains(&length) {
            let expected = format!("at most {}, the bytes of the file", bytes.len());
            return Err(name.field("length that the header states", length, expected));
        }
        if length < bytes.len() {
            let left = bytes.len() - length;
            parts
                .beside
                .push(format!("bytes after the container ({left})"));
        }
        let mut rest = &bytes[HEADER..length];
        let mut index = 0;
        while !rest.is_empty() {
            let field = || format!("chunk {index}: length");
            if rest.len() < CHUNK {
                let expected = format!("at least the {CHUNK} bytes of its header");
                return Err(name.field(field(), rest.len(), expected));
            }
            let (found, kind) = (u32(rest, 0) as usize, u32(rest, 4));
            let Some((content, after)) = rest[CHUNK..].split_at_checked(found) else {
                let expected = format!("at most {}, within the container", rest.len() - CHUNK);
                return Err(name.field(field(), found, expected));
            };
            match (index, kind) {
                (0, JSON) => parts.json = content,
                (0, _) => return Err(name.field("chunk 0", letters(kind), "JSON")),
                (1, BINARY) => parts.binary = Some(content),
                _ => {
                    let key = format!("chunk {index} ({})", letters(kind));
                    parts.beside.push(key);
                }
            }
            rest = after;
            index += 1;
        }
        Ok(parts)
    }
}

/// The type of a chunk as text.
fn letters(kind: u32) -> String {
    let own = kind.to_le_bytes();
    match own.iter().all(|byte| byte.is_ascii_graphic() || *byte == 0) {
        true => told(String::from_utf8_lossy(&own).trim_end_matches('\0')),
        false => format!("0x{kind:08x}"),
    }
}
