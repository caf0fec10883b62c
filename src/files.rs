//! Files that are whole or not there.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use thiserror::Error;

#[derive(Debug, Error)]
#[error("cannot write {path}: {source}; name a folder that can be written")]
pub(crate) struct FileError {
    path: PathBuf,
    source: std::io::Error,
}

/// Writes to a temporary name in the same folder, then renames.
pub(crate) fn write(path: &Path, text: &str) -> Result<(), FileError> {
    let fail = |source| FileError {
        path: path.to_owned(),
        source,
    };
    let folder = match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    };
    std::fs::create_dir_all(folder).map_err(fail)?;
    let mut file = tempfile::NamedTempFile::new_in(folder).map_err(fail)?;
    file.write_all(text.as_bytes()).map_err(fail)?;
    readable(file.as_file()).map_err(fail)?;
    file.persist(path).map_err(|e| fail(e.error))?;
    Ok(())
}

/// Writes a report as JSON.
pub(crate) fn write_json(path: &Path, report: &impl serde::Serialize) -> Result<(), FileError> {
    let mut text = serde_json::to_string_pretty(report).map_err(|e| FileError {
        path: path.to_owned(),
        source: e.into(),
    })?;
    text.push('\n');
    write(path, &text)
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
