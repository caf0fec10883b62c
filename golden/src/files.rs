//! Files that are whole or not there, and of bounded size.

use std::io::{Read as _, Write as _};
use std::path::Path;

/// Writes to a temporary name in the same folder, then renames.
///
/// # Errors
/// The folder does not exist or cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let mut file = beside(path)?;
    file.write_all(bytes)?;
    readable(file.as_file())?;
    file.persist(path).map_err(|e| e.error)?;
    Ok(())
}

/// Whether a file can be written here, found out before the work whose result
/// it is; makes its folder.
///
/// # Errors
/// The folder cannot be made or written.
pub fn prepare(path: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(folder(path))?;
    if path.is_dir() {
        return Err(std::io::ErrorKind::IsADirectory.into());
    }
    beside(path).map(drop)
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    }
}

/// A temporary file in the folder of another.
fn beside(path: &Path) -> std::io::Result<tempfile::NamedTempFile> {
    tempfile::Builder::new()
        .prefix(".potamoi")
        .tempfile_in(folder(path))
        // The temporary name, which the library adds, would say nothing to a user.
        .map_err(|e| std::io::Error::from(e.kind()))
}

/// Opens a file.
///
/// # Errors
/// The file cannot be read, or is none: devices and pipes have no end.
pub fn open(path: &Path) -> std::io::Result<std::fs::File> {
    let file = std::fs::File::open(path)?;
    if !file.metadata()?.is_file() {
        return Err(std::io::Error::other("not a regular file"));
    }
    Ok(file)
}

/// What a file holds; `None` if that is more than `most` bytes.
///
/// # Errors
/// The file cannot be read, or is none: devices and pipes have no end.
pub fn read(path: &Path, most: u64) -> std::io::Result<Option<Vec<u8>>> {
    let mut bytes = vec![];
    open(path)?.take(most + 1).read_to_end(&mut bytes)?;
    Ok((bytes.len() as u64 <= most).then_some(bytes))
}

/// Temporary files are private; what is written for others should not be.
#[cfg(unix)]
fn readable(file: &std::fs::File) -> std::io::Result<()> {
    use std::os::unix::fs::PermissionsExt as _;
    file.set_permissions(std::fs::Permissions::from_mode(0o644))
}

#[cfg(not(unix))]
fn readable(_: &std::fs::File) -> std::io::Result<()> {
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn no_more_is_read_than_was_allowed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("f");
        write(&path, b"abc").unwrap();
        assert_eq!(read(&path, 3).unwrap(), Some(b"abc".to_vec()));
        assert_eq!(read(&path, 2).unwrap(), None);
        #[cfg(unix)]
        assert!(read(Path::new("/dev/zero"), 1000).is_err());
        assert!(read(folder.path(), 1000).is_err());
    }

    #[test]
    fn a_file_is_replaced_whole_and_nothing_stays_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("f");
        for text in ["first", "second, longer", "3"] {
            write(&path, text.as_bytes()).unwrap();
            assert_eq!(std::fs::read_to_string(&path).unwrap(), text);
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        assert!(write(&folder.path().join("no/f"), b"x").is_err());
        prepare(&folder.path().join("new/f")).unwrap();
        assert!(prepare(&folder.path().join("new")).is_err());
        assert!(prepare(&path.join("g")).is_err(), "a file is no folder");
        let left = std::fs::read_dir(folder.path().join("new")).unwrap();
        assert_eq!(left.count(), 0);
    }
}
