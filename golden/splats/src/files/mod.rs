//! Splat files of every format that is read, told apart by their names.
//!
//! | name | format |
//! |---|---|
//! | `.ply` | 3D Gaussian splatting's, or PlayCanvas's packed one, as its header says |
//! | `.splat` | antimatter15's |
//! | `.spz` | Niantic's, versions 1 to 4 |
//! | `.sog`, or a folder with `meta.json`, or that file | PlayCanvas's SOG, version 2 |
//!
//! Memory stays in proportion to the file: nothing is reserved on a header's
//! word that the file is too short for.

mod error;
pub mod packed_ply;
pub mod sog;
pub mod splat;
pub mod spz;
pub mod spz_keys;
#[cfg(test)]
pub mod tests;
mod unpack;
mod values;
mod zip_end;

use std::io::Read as _;
use std::path::Path;

pub use error::FileError;
pub use error::Origin;

use super::axes::Axes;
use super::loaded::{Loaded, Raw};
use super::ply;
pub use zip_end::after_archive;

/// The endings of splat files, and the name that makes a folder one.
pub const ENDINGS: [&str; 4] = ["ply", "splat", "spz", "sog"];
/// What describes the images of an SOG folder.
const META: &str = "meta.json";
/// What lists the levels of detail of several SOG folders.
const LEVELS: &str = "lod-meta.json";
/// The largest file that is read whole, in bytes.
const LARGEST: u64 = 1 << 32;

/// The format of a file.
enum Format {
    Ply,
    Splat,
    Spz,
    Sog,
    /// Or its `meta.json`.
    SogFolder,
    /// Levels of detail in SOG folders, none of which is named.
    Levels,
}

fn format(path: &Path) -> Option<Format> {
    if path.is_dir() {
        return match () {
            () if path.join(META).is_file() => Some(Format::SogFolder),
            () if path.join(LEVELS).is_file() => Some(Format::Levels),
            () => None,
        };
    }
    let name = path.file_name()?.to_string_lossy().to_lowercase();
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    match ending.as_str() {
        "ply" => Some(Format::Ply),
        "splat" => Some(Format::Splat),
        "spz" => Some(Format::Spz),
        "sog" => Some(Format::Sog),
        "json" if name == META => Some(Format::SogFolder),
        "json" if name == LEVELS => Some(Format::Levels),
        _ => None,
    }
}

/// Whether the name is that of a splat file, there or not, or of a folder that
/// holds one.
#[must_use]
pub fn is_splats(path: &Path) -> bool {
    format(path).is_some()
}

/// Reads a splat file of any format, whose axes are those that are `asked` for, or else what it
/// says, or else what its format has; what is read is in the axes of PLY files (x right, y down,
/// z to the front).
///
/// # Errors
/// The file cannot be read, or is no complete file of its format.
pub fn read(path: &Path, asked: Option<Axes>) -> Result<Loaded, FileError> {
    let origin = path.display().to_string();
    let raw = match format(path) {
        Some(Format::Ply) => read_ply(path, &origin)?,
        Some(Format::Splat) => splat::raw(&whole(path)?, &origin)?,
        Some(Format::Spz) => spz::raw(&whole(path)?, &origin)?,
        Some(Format::Sog) => sog::raw(&whole(path)?, &origin)?,
        Some(Format::SogFolder) => {
            let folder = if path.is_dir() {
                Some(path)
            } else {
                path.parent()
            };
            sog::raw_folder(folder.unwrap_or(Path::new("")), &origin)?
        }
        Some(Format::Levels) => {
            let expected = format!("one of them: name the {META} of a level's folder");
            return Err(Origin(&origin).field("the scene", "several levels of detail", expected));
        }
        None => {
            return Err(FileError::Unknown {
                path: path.to_owned(),
                expected: format!(
                    "a name that ends in .{}, or a folder with a {META}",
                    ENDINGS.join(", .")
                ),
            });
        }
    };
    Ok(raw.turned(asked))
}

/// All bytes of a file that is not too large.
pub fn whole(path: &Path) -> Result<Vec<u8>, FileError> {
    limited(path, LARGEST)
}

fn limited(path: &Path, most: u64) -> Result<Vec<u8>, FileError> {
    let fail = |source| FileError::Read {
        path: path.to_owned(),
        source,
    };
    let bytes = potamoi_base::files::read(path, most).map_err(fail)?;
    bytes.ok_or_else(|| fail(std::io::Error::other(format!("more than {most} bytes"))))
}

/// Packed or not is known from the header alone.
pub fn read_ply(path: &Path, origin: &str) -> Result<Raw, FileError> {
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
