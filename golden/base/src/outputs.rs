//! Output files of a command: each is checked before any work, named once, and written atomically.

use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use thiserror::Error;

use crate::files;

/// Why a file cannot be written.
#[derive(Debug, Error)]
#[error("cannot write {path}: {source}; {remedy}")]
pub struct FileError {
    path: PathBuf,
    source: std::io::Error,
    /// The remedy.
    remedy: &'static str,
}

impl FileError {
    /// The error of a file or folder.
    #[must_use]
    pub fn new(path: &Path, source: std::io::Error) -> Self {
        let remedy = match source.kind() {
            ErrorKind::IsADirectory => "name a file",
            ErrorKind::AlreadyExists | ErrorKind::NotADirectory => "name a folder",
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "make room, or name another disk",
            _ => "name a folder that can be written",
        };
        Self {
            path: path.to_owned(),
            source: files::in_words(source),
            remedy,
        }
    }
}

/// Checks before any work that the results can be written, and creates their folders.
///
/// # Errors
/// An output cannot be written, or is named twice.
pub fn prepare<'a>(paths: impl IntoIterator<Item = Option<&'a PathBuf>>) -> Result<(), FileError> {
    static KNOWN: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
    for path in paths.into_iter().flatten() {
        let fail = |e| FileError::new(path, e);
        files::prepare(path).map_err(fail)?;
        // Streams may be written to twice.
        let Some(place) = files::place(path).map_err(fail)? else {
            continue;
        };
        let folder = place.parent().filter(|p| !p.as_os_str().is_empty());
        let folder = folder.unwrap_or(Path::new(".")).canonicalize();
        let whole = folder
            .map_err(fail)?
            .join(place.file_name().unwrap_or_default());
        if !known.insert(whole) {
            return Err(FileError {
                remedy: "name another file",
                ..fail(std::io::Error::other(
                    "it is another output of this command already",
                ))
            });
        }
    }
    Ok(())
}

/// Writes a file atomically, and creates its folder.
///
/// # Errors
/// The folder or the file cannot be written.
pub fn write(path: &Path, text: &str) -> Result<(), FileError> {
    let fail = |source| FileError::new(path, source);
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(fail)?;
    }
    files::write(path, text.as_bytes()).map_err(fail)
}

/// Writes a report as JSON.
///
/// # Errors
/// As [`write()`], or the report has no form in JSON.
pub fn write_json(path: &Path, report: &impl serde::Serialize) -> Result<(), FileError> {
    let text = serde_json::to_string_pretty(report);
    let mut text = text.map_err(|e| FileError::new(path, e.into()))?;
    text.push('\n');
    write(path, &text)
}
