//! `.splat` files: 32 bytes a Gaussian, without a header.
//!
//! Little-endian: centre as three floats, standard deviations as three floats, colour and opacity
//! as four bytes of 1/255, and the quaternion `w, x, y, z` as four bytes `128 + 128 q`. There are
//! no spherical harmonics above the constant. Source: the converter of antimatter15/splat, which
//! defined the format.

use super::error::{FileError, Origin};
use super::reader::{Reader, whole};
use super::values;
use crate::Cloud;
use crate::file_content::{Facts, Loaded, Raw};
use potamoi_base::file_keys::{Fate, Format, Key, Notes};

/// Keys of the format: parts of a row, since there is no header.
pub static FORMAT: Format = Format {
    name: "antimatter15's splat",
    files: "`.splat`: 32 bytes a Gaussian and no header",
    keys: &[
        Key {
            name: "position",
            fate: Fate::Honoured,
            about: "three floats",
        },
        Key {
            name: "scale",
            fate: Fate::Honoured,
            about: "three floats, not logarithms; 0 is the smallest normal float",
        },
        Key {
            name: "colour",
            fate: Fate::Honoured,
            about: "four bytes of 1/255, the last of them the opacity",
        },
        Key {
            name: "rotation",
            fate: Fate::Honoured,
            about: "four bytes `128 + 128 q`; of length 0 it is no rotation",
        },
    ],
    others: Fate::Refused,
};

/// The first bytes of files of other formats.
const OTHERS: [(&[u8], &str); 8] = [
    (b"ply\n", "PLY"),
    (b"ply\r", "PLY"),
    (b"\xef\xbb\xbf", "text"),
    (b"\x89PNG", "PNG"),
    (b"\xff\xd8\xff", "JPEG"),
    (b"NGSP", "SPZ"),
    (b"\x1f\x8b\x08", "gzip"),
    (b"PK\x03\x04", "ZIP"),
];
/// Bytes examined to recognise a text file.
const LOOKED_AT: usize = 1 << 12;
/// Bytes a Gaussian.
const ROW: usize = 32;

/// The registry entry of the format.
pub(super) static READER: Reader = Reader {
    endings: &["splat"],
    formats: &[&FORMAT],
    read: |path, origin| raw(&whole(path)?, origin),
};

/// Reads a cloud; `origin` names the file in errors. A standard deviation of 0, to which a small
/// one rounds, becomes the smallest normal float.
///
/// # Errors
/// The file is not a whole number of Gaussians, or the values do not form a valid cloud.
pub fn parse(bytes: &[u8], origin: &str) -> Result<Loaded, FileError> {
    Ok(raw(bytes, origin)?.turned(None))
}

pub(super) fn raw(bytes: &[u8], origin: &str) -> Result<Raw, FileError> {
    let name = Origin(origin);
    // Any bytes would do, so that those of another format are told by how they begin.
    let other = OTHERS.iter().find(|(start, _)| bytes.starts_with(start));
    let text = is_text(bytes).then_some("text");
    if let Some(format) = other.map(|(_, format)| *format).or(text) {
        let expected = "rows of 32 bytes; give the file the ending of its format";
        return Err(name.field("content", format!("a {format} file"), expected));
    }
    let (rows, rest) = bytes.as_chunks::<ROW>();
    if !rest.is_empty() {
        let expected = format!("a multiple of {ROW}, the bytes of a Gaussian");
        return Err(name.field("length in bytes", bytes.len(), expected));
    }
    if !bytes.is_empty() && bytes.iter().all(|byte| *byte == 0) {
        let expected = "Gaussians: the file was reserved and never written; write it again";
        return Err(name.field("content", "zeros alone", expected));
    }
    let float = |row: &[u8; ROW], i: usize| {
        f32::from_le_bytes([row[4 * i], row[4 * i + 1], row[4 * i + 2], row[4 * i + 3]])
    };
    let mut raised = 0;
    for (index, row) in rows.iter().enumerate() {
        for axis in 0..3 {
            let scale = float(row, 3 + axis);
            if !(0.0..f32::INFINITY).contains(&scale) {
                let field = format!("Gaussian {index}: scale[{axis}]");
                return Err(name.field(field, scale, "a finite number of at least 0"));
            }
            raised += u64::from(scale < f32::MIN_POSITIVE);
        }
    }
    let logits = values::logits();
    let count = rows.len();
    let cloud = Cloud::new(
        0,
        values::each(count, |i| [0, 1, 2].map(|k| float(&rows[i], k))),
        values::each(count, |i| {
            [3, 4, 5].map(|k| float(&rows[i], k).max(f32::MIN_POSITIVE).ln())
        }),
        values::each(count, |i| {
            [28, 29, 30, 31].map(|k| (f32::from(rows[i][k]) - 128.0) / 128.0)
        }),
        values::each(count, |i| logits[usize::from(rows[i][27])]),
        values::coefficients(count, 0, |i, out| {
            out[0] = [24, 25, 26].map(|k| values::constant(f64::from(rows[i][k]) / 255.0));
        }),
    );
    let mut facts = Facts::of(&FORMAT);
    facts.clamp("sizes of 0, raised to the smallest normal float", raised);
    let cloud = cloud.map_err(|e| name.cloud(e))?;
    Ok(Raw::new(cloud, Notes::default()).with(facts))
}

/// Whether a file begins with only letters and line ends, which rows of floats do not.
fn is_text(bytes: &[u8]) -> bool {
    let start = &bytes[..bytes.len().min(LOOKED_AT)];
    let is_letter = |byte: &u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    !start.is_empty() && start.iter().all(is_letter)
}
