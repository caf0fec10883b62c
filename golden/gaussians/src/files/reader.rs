//! The interface of a splat file format.

use std::path::Path;

use super::error::FileError;
use crate::file_content::Raw;
use potamoi_base::file_keys::Format;

/// The largest file that is read, in bytes.
pub(super) const LARGEST: u64 = 1 << 32;

/// A splat file format: file extensions, keys and reader.
#[derive(Debug)]
pub struct Reader {
    /// File extensions, in lower case.
    pub endings: &'static [&'static str],
    /// Its keys; several if files with one extension have several forms.
    pub formats: &'static [&'static Format],
    /// Reads a file; the second argument names it in errors.
    pub(super) read: fn(&Path, &str) -> Result<Raw, FileError>,
}

/// The reader for the extension of a file.
pub(super) fn of<'a>(readers: &[&'a Reader], path: &Path) -> Option<&'a Reader> {
    let ending = path.extension()?.to_string_lossy().to_lowercase();
    let mut readers = readers.iter().copied();
    readers.find(|reader| reader.endings.contains(&&*ending))
}

/// All bytes of a file of at most 4 GiB.
///
/// # Errors
/// The file cannot be read or is larger.
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
