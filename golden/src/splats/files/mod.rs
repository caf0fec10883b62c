//! Splat files of every format that is read, told apart by their names.
//!
//! | name | format |
//! |---|---|
//! | `.ply` | 3D Gaussian splatting's, or PlayCanvas's packed one, as its header says |
//! | `.splat` | antimatter15's |
//! | `.spz` | Niantic's, versions 2 to 4 |
//! | `.sog`, or a folder with `meta.json` | PlayCanvas's SOG, version 2 |
//!
//! Memory stays in proportion to the file: nothing is reserved on a header's
//! word that the file is too short for.

mod error;
pub mod packed_ply;
pub mod sog;
pub mod splat;
pub mod spz;
#[cfg(test)]
pub(super) mod tests;
mod unpack;
mod values;

use std::io::{Read as _, Seek as _};
use std::path::Path;

pub use error::FileError;
pub(super) use error::Origin;

use super::cloud::Cloud;
use super::ply;

/// The endings of splat files, and the name that makes a folder one.
pub const ENDINGS: [&str; 4] = ["ply", "splat", "spz", "sog"];
/// What describes the images of an SOG folder.
const META: &str = "meta.json";
/// The largest file that is read whole, in bytes.
const LARGEST: u64 = 1 << 32;

/// The format of a file.
enum Format {
    Ply,
    Splat,
    Spz,
    Sog,
    SogFolder,
}

fn format(path: &Path) -> Option<Format> {
    if path.is_dir() {
        return path.join(META).is_file().then_some(Format::SogFolder);
    }
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    match ending.as_str() {
        "ply" => Some(Format::Ply),
        "splat" => Some(Format::Splat),
        "spz" => Some(Format::Spz),
        "sog" => Some(Format::Sog),
        _ => None,
    }
}

/// Whether the name is that of a splat file, there or not, or of a folder that
/// holds one.
#[must_use]
pub fn is_splats(path: &Path) -> bool {
    format(path).is_some()
}

/// Reads a splat file of any format; centres and rotations are in the axes of
/// PLY files (x right, y down, z to the front), whatever those of the file.
///
/// # Errors
/// The file cannot be read, or is no complete file of its format.
pub fn read(path: &Path) -> Result<Cloud, FileError> {
    let origin = path.display().to_string();
    match format(path) {
        Some(Format::Ply) => read_ply(path, &origin),
        Some(Format::Splat) => splat::parse(&whole(path)?, &origin),
        Some(Format::Spz) => spz::parse(&whole(path)?, &origin),
        Some(Format::Sog) => sog::parse(&whole(path)?, &origin),
        Some(Format::SogFolder) => sog::read_folder(path),
        None => Err(FileError::Unknown {
            path: path.to_owned(),
            expected: format!(
                "a name that ends in .{}, or a folder with a {META}",
                ENDINGS.join(", .")
            ),
        }),
    }
}

/// All bytes of a file that is not too large.
pub(super) fn whole(path: &Path) -> Result<Vec<u8>, FileError> {
    limited(path, LARGEST)
}

fn limited(path: &Path, most: u64) -> Result<Vec<u8>, FileError> {
    let fail = |source| FileError::Read {
        path: path.to_owned(),
        source,
    };
    let bytes = crate::files::read(path, most).map_err(fail)?;
    bytes.ok_or_else(|| fail(std::io::Error::other(format!("more than {most} bytes"))))
}

/// Packed or not is known from the header alone.
fn read_ply(path: &Path, origin: &str) -> Result<Cloud, FileError> {
    let fail = |source| FileError::Read {
        path: path.to_owned(),
        source,
    };
    let (mut reader, length) = ply::open(path)?;
    let header = ply::header::read(&mut reader, origin)?;
    if packed_ply::is_packed(&header.ply) {
        let mut body = vec![];
        reader
            .take(length.min(LARGEST))
            .read_to_end(&mut body)
            .map_err(fail)?;
        return packed_ply::decode(&header, &body, origin);
    }
    reader.rewind().map_err(fail)?;
    Ok(ply::parse(reader, length, origin)?)
}
