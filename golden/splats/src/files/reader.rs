//! What a format of splat files brings.

use std::path::Path;

use super::error::FileError;
use crate::loaded::Raw;
use potamoi_base::record::Format;

/// The largest file that is read whole, in bytes.
pub(super) const LARGEST: u64 = 1 << 32;

/// A format of splat files: how its files are named, what they say, and what reads them.
#[derive(Debug)]
pub struct Reader {
    /// The ending of its files, in lower case.
    pub ending: &'static str,
    /// Its keys; several where files of one ending have several forms.
    pub formats: &'static [&'static Format],
    /// Reads a file, which errors name by the second argument.
    pub(super) read: fn(&Path, &str) -> Result<Raw, FileError>,
}

/// The reader of a file by its ending.
pub(super) fn of<'a>(readers: &[&'a Reader], path: &Path) -> Option<&'a Reader> {
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    let mut readers = readers.iter().copied();
    readers.find(|reader| reader.ending == ending)
}

/// All bytes of a file that is not too large.
///
/// # Errors
/// It cannot be read, or is larger.
pub fn whole(path: &Path) -> Result<Vec<u8>, FileError> {
    limited(path, LARGEST)
}

pub(super) fn limited(path: &Path, most: u64) -> Result<Vec<u8>, FileError> {
    let fail = |source| FileError::Read {
        path: path.to_owned(),
        source,
    };
    let bytes = potamoi_base::files::read(path, most).map_err(fail)?;
    bytes.ok_or_else(|| fail(std::io::Error::other(format!("more than {most} bytes"))))
}
