//! The containers of `.spz` files.
//!
//! Versions 1 to 3 are one gzip stream, or its content: 16 bytes of header, the arrays one after
//! another, then extensions. Version 4 has 32 bytes of header, extensions, a table with the packed
//! and unpacked size of each stream, and a ZSTD stream for each array that is not empty.

use std::io::{ErrorKind, Read};

use flate2::bufread::GzDecoder;
use rayon::prelude::*;
use ruzstd::decoding::StreamingDecoder;

use super::error::{FileError, Origin};
use super::spz_keys::{EXTENDED, FORMAT};
use potamoi_base::file_keys::FileKeys;
use potamoi_base::sh;

const MAGIC: &[u8; 4] = b"NGSP";
/// What a gzip stream begins with.
const GZIP: &[u8] = b"\x1f\x8b";
/// Bytes of the header up to version 3, and of its part in version 4.
const HEADER: usize = 16;
/// Bytes of the header of version 4.
const HEADER_4: usize = 32;
/// Bytes of an entry of the table of streams.
const ENTRY: usize = 16;
/// The largest ZSTD window of small streams, as the RFC recommends, in bytes.
const WINDOW: u64 = 8 << 20;
/// Maximum number of unpacked bytes of extensions after the arrays.
const EXTRA: usize = 1 << 20;
/// Names of the arrays in error messages.
const NAMES: [&str; 6] = [
    "positions",
    "alphas",
    "colors",
    "scales",
    "rotations",
    "spherical harmonics",
];

/// The header fields that all versions share.
pub(super) struct Header {
    /// Version, 1 to 4.
    pub(super) version: u32,
    /// Number of Gaussians, at least one.
    pub(super) count: usize,
    /// Degree of the spherical harmonics, 0 to 3.
    pub(super) degree: usize,
    /// Fraction bits of a position.
    pub(super) fraction_bits: u8,
    flags: u8,
    /// Reserved up to version 3; the number of streams in version 4.
    last: u8,
}

impl Header {
    /// Reads the header. `packed` is the length of the file.
    fn read(bytes: &[u8; HEADER], packed: usize, name: Origin<'_>) -> Result<Self, FileError> {
        let word = |at: usize| {
            u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
        };
        if !bytes.starts_with(MAGIC) {
            let shown: Vec<String> = bytes[..4].iter().map(|b| format!("{b:02x}")).collect();
            let expected = "4e 47 53 50, the letters NGSP";
            return Err(name.field("magic", shown.join(" "), expected));
        }
        let version = word(4);
        if !(1..=4).contains(&version) {
            return Err(name.field("version", version, "1, 2, 3 or 4"));
        }
        let (count, degree, fraction_bits) = (word(8) as usize, bytes[12], bytes[13]);
        if !(1..=packed).contains(&count) {
            let expected = format!(
                "1 to {packed}: a byte of the file for each at the least, and it has {packed} bytes; a \
                 file with fewer than it names is cut off"
            );
            return Err(name.field("number of Gaussians", count, expected));
        }
        if usize::from(degree) > sh::MAX_DEGREE {
            let expected = format!("0 to {}", sh::MAX_DEGREE);
            return Err(name.field("degree of spherical harmonics", degree, expected));
        }
        if fraction_bits > 24 {
            return Err(name.field("fractional bits", fraction_bits, "0 to 24"));
        }
        Ok(Self {
            version,
            count,
            degree: usize::from(degree),
            fraction_bits,
            flags: bytes[14],
            last: bytes[15],
        })
    }

    /// Coefficient bytes above the constant, for one Gaussian.
    pub(super) const fn rest(&self) -> usize {
        3 * (sh::coefficients(self.degree) - 1)
    }

    /// Bytes of each array.
    fn lengths(&self) -> [usize; 6] {
        let position = if self.version == 1 { 6 } else { 9 };
        let rotation = if self.version <= 2 { 3 } else { 4 };
        [position, 1, 3, 3, rotation, self.rest()].map(|each| each * self.count)
    }

    /// Keys of the set flags.
    fn flags(&self) -> impl Iterator<Item = String> {
        let set = (0..8).map(|bit| self.flags & 1 << bit);
        set.filter(|bit| *bit != 0)
            .map(|bit| format!("flag 0x{bit:02x}"))
    }

    fn is_extended(&self) -> bool {
        self.flags().any(|key| key == EXTENDED)
    }
}

/// The arrays of a file, with the lengths that the header requires.
pub(super) struct Arrays {
    pub(super) header: Header,
    pub(super) bytes: [Vec<u8>; 6],
    /// Flags, extensions and all other content of the file.
    pub(super) record: FileKeys<Vec<u8>>,
}

/// Unpacks a file of any version.
pub(super) fn unpack(bytes: &[u8], name: Origin<'_>) -> Result<Arrays, FileError> {
    if !bytes.starts_with(MAGIC) {
        return gzip(bytes, name);
    }
    match bytes.first_chunk() {
        Some(head) if Header::read(head, bytes.len(), name)?.version < 4 => {
            body(&mut &*bytes, bytes.len(), name)
        }
        _ => streams(bytes, name),
    }
}

fn gzip(bytes: &[u8], name: Origin<'_>) -> Result<Arrays, FileError> {
    let mut reader = GzDecoder::new(bytes);
    let read = body(&mut reader, bytes.len(), name);
    let rest = reader.into_inner();
    if read.is_err() && rest.starts_with(GZIP) {
        let problem = "it ends early, and another follows: pack all of it as one stream";
        return Err(name.part("gzip stream", problem));
    }
    let mut arrays = read?;
    let left = rest.len();
    if left > 0 {
        arrays
            .record
            .add(format!("bytes after the gzip stream ({left})"), vec![]);
    }
    Ok(arrays)
}

/// Header, arrays and extensions of a file of `file` bytes, up to version 3.
fn body(reader: &mut impl Read, file: usize, name: Origin<'_>) -> Result<Arrays, FileError> {
    let mut head = [0; HEADER];
    reader.read_exact(&mut head).map_err(|error| {
        let problem = match error.kind() {
            ErrorKind::UnexpectedEof => {
                format!("it ends early: the {file} bytes of the file unpack to less than a header of {HEADER}")
            }
            _ => format!("the {file} bytes of the file are no gzip stream, or its data is wrong"),
        };
        name.part("gzip stream", problem)
    })?;
    let header = Header::read(&head, file, name)?;
    if header.version == 4 {
        return Err(name.field("version", 4, "1, 2 or 3 in a gzip stream"));
    }
    let lengths = header.lengths();
    let needed: usize = lengths.iter().sum();
    let mut body = vec![];
    // To the end, where the checksum is.
    let unpacked = reader
        .take((needed + EXTRA + 1) as u64)
        .read_to_end(&mut body);
    unpacked.map_err(|_| {
        let problem = format!(
            "it ends early, or its data or checksum is wrong: the {file} bytes of the file unpack to {} after \
             the header, and its {} Gaussians take {needed}",
            body.len(),
            header.count
        );
        name.part("gzip stream", problem)
    })?;
    if !(needed..=needed + EXTRA).contains(&body.len()) {
        let expected = format!("{needed}, and at most {EXTRA} of extensions");
        return Err(name.field("bytes after the header", body.len(), expected));
    }
    let mut left = body.as_slice();
    let bytes = lengths.map(|length| {
        let (array, rest) = left.split_at(length);
        left = rest;
        array.to_vec()
    });
    let mut record = record(&header, left, "the arrays", name)?;
    if header.last != 0 {
        record.add(
            format!("reserved byte of the header ({})", header.last),
            vec![],
        );
    }
    Ok(Arrays {
        header,
        bytes,
        record,
    })
}

/// Flags and extensions.
fn record(
    header: &Header,
    extensions: &[u8],
    after: &str,
    name: Origin<'_>,
) -> Result<FileKeys<Vec<u8>>, FileError> {
    let mut all: Vec<_> = header.flags().map(|key| (key, vec![])).collect();
    // Without the flag bytes that happen to be records say nothing.
    if header.is_extended() {
        all.extend(records(extensions, name)?);
    } else if !extensions.is_empty() {
        let key = format!("bytes after {after} ({})", extensions.len());
        all.push((key, vec![]));
    }
    Ok(FileKeys::new(&FORMAT, all))
}

fn streams(bytes: &[u8], name: Origin<'_>) -> Result<Arrays, FileError> {
    let Some(head) = bytes.first_chunk::<HEADER_4>() else {
        let expected = format!("at least the {HEADER_4} of a header");
        return Err(name.field("length in bytes", bytes.len(), expected));
    };
    let common = head.first_chunk().unwrap_or(&[0; HEADER]);
    let header = Header::read(common, bytes.len(), name)?;
    let lengths = header.lengths();
    let wanted = lengths.iter().filter(|l| **l > 0).count();
    let streams = usize::from(header.last);
    let table = u32::from_le_bytes([head[16], head[17], head[18], head[19]]) as usize;
    if streams != wanted {
        return Err(name.field("number of streams", streams, wanted.to_string()));
    }
    let most = bytes.len().saturating_sub(streams * ENTRY);
    if !(HEADER_4..=most).contains(&table) {
        let expected = format!("{HEADER_4} to {most}, within the file");
        return Err(name.field("offset of the table of streams", table, expected));
    }
    let mut record = record(&header, &bytes[HEADER_4..table], "the header", name)?;
    if head[20..].iter().any(|byte| *byte != 0) {
        record.add("reserved bytes of the header".to_owned(), vec![]);
    }
    let (entries, mut packed) = bytes[table..].split_at(streams * ENTRY);
    let mut parts = [&[][..]; 6];
    for ((part, index), entry) in parts.iter_mut().zip(0..).zip(entries.chunks(ENTRY)) {
        let [found, unpacked] = [0, 8].map(|at| {
            let mut word = [0; 8];
            word.copy_from_slice(&entry[at..at + 8]);
            u64::from_le_bytes(word)
        });
        let length: usize = lengths[index];
        if unpacked != length as u64 {
            let field = format!("unpacked bytes of `{}`", NAMES[index]);
            return Err(name.field(field, unpacked, length.to_string()));
        }
        let Some((this, rest)) = usize::try_from(found)
            .ok()
            .and_then(|n| packed.split_at_checked(n))
        else {
            let field = format!("packed bytes of `{}`", NAMES[index]);
            let expected = format!(
                "at most {}, which the file has left; it is cut off or damaged",
                packed.len()
            );
            return Err(name.field(field, found, expected));
        };
        (*part, packed) = (this, rest);
    }
    if !packed.is_empty() {
        record.add(
            format!("bytes after the streams ({})", packed.len()),
            vec![],
        );
    }
    let unpacked: Vec<Result<Vec<u8>, FileError>> = (0..streams)
        .into_par_iter()
        .map(|i| {
            zstd(parts[i], lengths[i])
                .map_err(|message| name.part(format!("stream `{}`", NAMES[i]), message))
        })
        .collect();
    // The first stream that is wrong is told, whichever thread was first.
    let unpacked: Vec<Vec<u8>> = unpacked.into_iter().collect::<Result<_, _>>()?;
    let mut unpacked = unpacked.into_iter();
    Ok(Arrays {
        header,
        record,
        bytes: [(); 6].map(|()| unpacked.next().unwrap_or_default()),
    })
}

/// Splits extensions into records of type, length and content.
fn records(mut bytes: &[u8], name: Origin<'_>) -> Result<Vec<(String, Vec<u8>)>, FileError> {
    let word = |b: &[u8], at: usize| u32::from_le_bytes([b[at], b[at + 1], b[at + 2], b[at + 3]]);
    let mut all = vec![];
    while !bytes.is_empty() {
        if bytes.len() < 8 {
            let expected = "8 for each, its type and its length, and its content";
            return Err(name.field("bytes of an extension", bytes.len(), expected));
        }
        let (kind, length) = (word(bytes, 0), word(bytes, 4) as usize);
        let Some((content, rest)) = bytes[8..].split_at_checked(length) else {
            let expected = format!("at most {}, within the extensions", bytes.len() - 8);
            return Err(name.field("length of an extension", length, expected));
        };
        all.push((format!("extension 0x{kind:08x}"), content.to_vec()));
        bytes = rest;
    }
    Ok(all)
}

/// Decodes one ZSTD frame of a known length.
fn zstd(packed: &[u8], length: usize) -> Result<Vec<u8>, String> {
    // The decoder holds a window back, whatever its size.
    let window = window(packed).ok_or("no ZSTD frame")?;
    let most = (length as u64).next_power_of_two().max(WINDOW);
    if window > most {
        return Err(format!(
            "a window of {window} bytes: expected at most {most}"
        ));
    }
    let damaged = || "it cannot be unpacked".to_owned();
    let mut decoder = StreamingDecoder::new(packed).map_err(|_| damaged())?;
    let mut bytes = vec![];
    decoder
        .by_ref()
        .take(length as u64 + 1)
        .read_to_end(&mut bytes)
        .map_err(|_| damaged())?;
    if bytes.len() != length {
        let found = if bytes.len() < length { "less" } else { "more" };
        return Err(format!("{found} than the {length} bytes of its entry"));
    }
    let decoder = decoder.into_frame_decoder();
    match decoder.get_checksum_from_data() {
        Some(sum) if decoder.get_calculated_checksum() != Some(sum) => {
            Err("its checksum is another".to_owned())
        }
        _ => Ok(bytes),
    }
}

/// The window of a ZSTD frame in bytes, from its header (RFC 8878, 3.1.1.1).
fn window(frame: &[u8]) -> Option<u64> {
    let rest = frame.strip_prefix(&[0x28, 0xb5, 0x2f, 0xfd])?;
    let (descriptor, rest) = rest.split_first()?;
    if descriptor & 0x20 == 0 {
        let code = *rest.first()?;
        let base = 1u64 << (10 + (code >> 3));
        return Some(base + base / 8 * u64::from(code & 7));
    }
    // A single segment: as large as the content.
    let dictionary = [0, 1, 2, 4][usize::from(descriptor & 3)];
    let width = [1, 2, 4, 8][usize::from(descriptor >> 6)];
    let field = rest.get(dictionary..dictionary + width)?;
    let mut word = [0; 8];
    word[..width].copy_from_slice(field);
    Some(u64::from_le_bytes(word).saturating_add(if width == 2 { 256 } else { 0 }))
}

#[cfg(test)]
mod tests {
    use ruzstd::encoding::{CompressionLevel, compress_to_vec};

    use super::*;

    #[test]
    fn length_and_checksum_of_a_frame_are_held_to() {
        let bytes: Vec<u8> = (0..5000u32).map(|i| ((i * i) >> 7) as u8).collect();
        let mut frame = compress_to_vec(bytes.as_slice(), CompressionLevel::Fastest);
        assert_eq!(frame[4] & 4, 4, "a frame with a checksum");
        assert_eq!(zstd(&frame, 5000), Ok(bytes));
        assert!(zstd(&frame, 4999).is_err_and(|e| e.contains("more than the 4999 bytes")));
        assert!(zstd(&frame, 5001).is_err_and(|e| e.contains("less than the 5001 bytes")));
        let end = frame.len() - 1;
        frame[end] ^= 1;
        assert!(zstd(&frame, 5000).is_err_and(|e| e.contains("checksum")));
    }

    #[test]
    fn windows_are_read_as_the_rfc_says() {
        let frame = |rest: &[u8]| window(&[&[0x28, 0xb5, 0x2f, 0xfd], rest].concat());
        assert_eq!(frame(&[0, 0]), Some(1024));
        assert_eq!(frame(&[0, 0b0000_1111]), Some(2048 + 7 * 256));
        assert_eq!(frame(&[0x20, 7]), Some(7));
        assert_eq!(frame(&[0x61, 99, 1, 2]), Some(0x201 + 256));
        assert_eq!(frame(&[0xa0, 1, 2, 3, 4]), Some(0x0403_0201));
        assert_eq!(frame(&[0xa0, 1, 2, 3]), None);
        assert_eq!(window(b"no frame"), None);
    }
}
