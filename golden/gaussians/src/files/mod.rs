//! Readers of all splat file formats, selected by file name.
//!
//! | name | format |
//! |---|---|
//! | `.ply` | 3D Gaussian splatting's, or PlayCanvas's packed one, as its header says |
//! | `.splat` | antimatter15's |
//! | `.spz` | Niantic's, versions 1 to 4 |
//! | `.sog`, or a folder with `meta.json`, or that file | PlayCanvas's SOG, version 2 |
//! | a folder with `lod-meta.json`, or that file | PlayCanvas's streamed SOG, a level of it |
//! | `.ksplat` | mkkellogg's, version 0.1 |
//! | `.glb`, `.gltf` | glTF with `KHR_gaussian_splatting` |
//!
//! A `.lcc` is refused by name.
//!
//! Memory is proportional to the file: a header cannot reserve more than its file can hold.

mod bytes;
mod error;
pub mod gltf;
mod json;
pub mod ksplat;
pub mod packed_ply;
mod reader;
pub mod sog;
pub mod splat;
pub mod spz;
pub mod spz_keys;
#[cfg(test)]
pub mod tests;
mod unpack;
mod values;

use std::io::Read as _;
use std::path::Path;

pub use error::FileError;
pub use error::Origin;

use super::axes::Axes;
use super::file_content::{Facts, Loaded, Raw};
use super::ply;
use reader::LARGEST;
pub use reader::{Reader, whole};
use sog::META;
use sog::levels::LEVELS;

/// Every format, in the order of the book's table. A new one is a file in this folder and a line
/// here.
pub static READERS: [&Reader; 7] = [
    &PLY,
    &splat::READER,
    &spz::READER,
    &sog::READER,
    &sog::levels::KEYS,
    &ksplat::READER,
    &gltf::READER,
];

/// Endings of files of Gaussians that are not read, and whose they are.
const NOT_READ: [(&str, &str); 2] = [("lcc", "XGRIDS's LCC"), ("lcc2", "XGRIDS's LCC 2")];

/// Both PLY formats, which are distinguished by their headers.
static PLY: Reader = Reader {
    endings: &["ply"],
    formats: &[&ply::FORMAT, &packed_ply::FORMAT],
    read: read_ply,
};

/// The kind of file that a path names.
enum Named<'a> {
    File(&'a Reader),
    /// An SOG folder, or its `meta.json`.
    SogFolder,
    /// Levels of detail in SOG folders, or the file that lists them.
    Levels,
    /// A format that is not read, by name.
    NotRead(&'static str),
}

fn named<'a>(readers: &[&'a Reader], path: &Path) -> Option<Named<'a>> {
    if path.is_dir() {
        return match () {
            () if path.join(META).is_file() => Some(Named::SogFolder),
            () if path.join(LEVELS).is_file() => Some(Named::Levels),
            () => None,
        };
    }
    match path.file_name()?.to_string_lossy().to_lowercase().as_str() {
        META => Some(Named::SogFolder),
        LEVELS => Some(Named::Levels),
        _ => match reader::of(readers, path) {
            Some(reader) => Some(Named::File(reader)),
            None => not_read(path).map(Named::NotRead),
        },
    }
}

/// The format of a file that is known and not read.
fn not_read(path: &Path) -> Option<&'static str> {
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    let found = NOT_READ.iter().find(|(own, _)| *own == ending);
    found.map(|(_, format)| *format)
}

/// File extensions of splat files.
#[must_use]
pub fn endings() -> Vec<&'static str> {
    let all = READERS.iter().flat_map(|reader| reader.endings);
    all.copied().collect()
}

/// Whether the name is that of a splat file, existing or not, or of a folder with one.
#[must_use]
pub fn is_splats(path: &Path) -> bool {
    named(&READERS, path).is_some()
}

/// Reads a splat file of any format. Its axes are those `asked` for, or else those that it names,
/// or else those of its format. The result has the axes of PLY files (x right, y down, z front).
///
/// # Errors
/// The file cannot be read, or is not a complete file of its format.
pub fn read(path: &Path, asked: Option<Axes>) -> Result<Loaded, FileError> {
    read_by(&READERS, path, asked, None)
}

/// As [`read`], at a level of detail of streamed SOG; 0, the finest, unless given.
///
/// # Errors
/// Those of [`read`], or the file has no such level, or no levels.
pub fn read_level(
    path: &Path,
    asked: Option<Axes>,
    level: Option<usize>,
) -> Result<Loaded, FileError> {
    read_by(&READERS, path, asked, level)
}

/// Reads a file by some of the formats.
fn read_by(
    readers: &[&Reader],
    path: &Path,
    asked: Option<Axes>,
    level: Option<usize>,
) -> Result<Loaded, FileError> {
    let origin = path.display().to_string();
    let found = named(readers, path);
    if let Some(level) = level.filter(|_| !matches!(found, Some(Named::Levels))) {
        let expected = format!("it left out: only a {LEVELS} has levels of detail");
        return Err(Origin(&origin).field("level", level, expected));
    }
    let raw = match found {
        Some(Named::File(reader)) => sized((reader.read)(path, &origin)?, path),
        Some(Named::SogFolder) => {
            let folder = if path.is_dir() {
                Some(path)
            } else {
                path.parent()
            };
            sog::raw_folder(folder.unwrap_or(Path::new("")), &origin)?
        }
        Some(Named::Levels) => sog::levels::raw_levels(path, level, &origin)?,
        Some(Named::NotRead(format)) => {
            return Err(FileError::NotRead {
                path: path.to_owned(),
                format,
            });
        }
        None => {
            return Err(FileError::Unknown {
                path: path.to_owned(),
                expected: format!(
                    "a name that ends in .{}, or a folder with a {META} or {LEVELS}",
                    endings().join(", .")
                ),
            });
        }
    };
    Ok(raw.turned(asked))
}

/// Adds the bytes of the file itself to those of files that it names.
fn sized(mut raw: Raw, path: &Path) -> Raw {
    let own = std::fs::metadata(path).map_or(0, |own| own.len());
    let bytes = raw.facts.bytes + own;
    raw.facts = Facts { bytes, ..raw.facts };
    raw
}

/// Reads either PLY format; the header alone selects it.
fn read_ply(path: &Path, origin: &str) -> Result<Raw, FileError> {
    let fail = |source| FileError::Read {
        path: path.to_owned(),
        source,
    };
    let (mut reader, length) = potamoi_containers::ply::open(path)?;
    let header = potamoi_containers::ply::header::read(&mut reader, origin)?;
    if packed_ply::is_packed(&header.ply) {
        let mut body = vec![];
        reader
            .by_ref()
            .take(length.min(LARGEST))
            .read_to_end(&mut body)
            .map_err(fail)?;
        return packed_ply::decode(&header, &body, origin);
    }
    Ok(ply::body(&header, reader, length, origin)?)
}
