//! Readers of all splat file formats, selected by file name.
//!
//! | name | format |
//! |---|---|
//! | `.ply` | 3D Gaussian splatting's, or PlayCanvas's packed one, as its header says |
//! | `.splat` | antimatter15's |
//! | `.spz` | Niantic's, versions 1 to 4 |
//! | `.sog`, or a folder with `meta.json`, or that file | PlayCanvas's SOG, version 2 |
//!
//! Memory is proportional to the file: a header cannot reserve more than its file can hold.

mod error;
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
use super::file_content::{Loaded, Raw};
use super::ply;
use reader::LARGEST;
pub use reader::{Reader, whole};

/// Every format, in the order of the book's table. A new one is a file in this folder and a line
/// here.
pub static READERS: [&Reader; 4] = [&PLY, &splat::READER, &spz::READER, &sog::READER];

/// Both PLY formats, which are distinguished by their headers.
static PLY: Reader = Reader {
    ending: "ply",
    formats: &[&ply::FORMAT, &packed_ply::FORMAT],
    read: read_ply,
};

/// The file that describes the images of an SOG folder.
const META: &str = "meta.json";
/// The file that lists the levels of detail of several SOG folders.
const LEVELS: &str = "lod-meta.json";

/// The kind of file that a path names.
enum Named<'a> {
    File(&'a Reader),
    /// An SOG folder, or its `meta.json`.
    SogFolder,
    /// Levels of detail in SOG folders, without a choice of one.
    Levels,
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
        _ => reader::of(readers, path).map(Named::File),
    }
}

/// File extensions of splat files.
#[must_use]
pub fn endings() -> Vec<&'static str> {
    READERS.iter().map(|reader| reader.ending).collect()
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
    read_by(&READERS, path, asked)
}

/// Reads a file by some of the formats.
fn read_by(readers: &[&Reader], path: &Path, asked: Option<Axes>) -> Result<Loaded, FileError> {
    let origin = path.display().to_string();
    let raw = match named(readers, path) {
        Some(Named::File(reader)) => (reader.read)(path, &origin)?,
        Some(Named::SogFolder) => {
            let folder = if path.is_dir() {
                Some(path)
            } else {
                path.parent()
            };
            sog::raw_folder(folder.unwrap_or(Path::new("")), &origin)?
        }
        Some(Named::Levels) => {
            let expected = format!("one of them: name the {META} of a level's folder");
            return Err(Origin(&origin).field("the scene", "several levels of detail", expected));
        }
        None => {
            return Err(FileError::Unknown {
                path: path.to_owned(),
                expected: format!(
                    "a name that ends in .{}, or a folder with a {META}",
                    endings().join(", .")
                ),
            });
        }
    };
    Ok(raw.turned(asked))
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
