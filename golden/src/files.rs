//! Files that are whole or not there, and of bounded size.

use std::io::Write as _;
use std::path::Path;

pub use potamoi_formats::files::{open, read, read_text};

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
