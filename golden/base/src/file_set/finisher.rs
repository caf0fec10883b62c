//! Last step of an emission, in a process that outlives a killed one.
//!
//! Once a set is committed, its files are moved into place one by one. A separate process of this
//! program does that in a process group of its own, so that a killed `emit` leaves either the old
//! set or the new one.

use std::os::unix::process::CommandExt as _;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use super::{FileSetError, finish, is_finished};

/// Environment variable of that process: the folder of the set.
const FOLDER: &str = "POTAMOI_FINISH_EMITTED";

/// Runs the step, if this is that process: a program that calls [`finish_apart`] calls this first,
/// and ends with the result.
#[must_use]
pub fn finish_if_asked() -> Option<Result<(), FileSetError>> {
    let folder = PathBuf::from(std::env::var_os(FOLDER)?);
    Some(finish(&folder))
}

/// Runs the step in such a process, and waits for it.
///
/// # Errors
/// A file cannot be renamed or removed.
pub fn finish_apart(out: &Path) -> Result<(), FileSetError> {
    if is_finished(out) {
        return Ok(());
    }
    let start = |own: PathBuf| {
        Command::new(own)
            .env(FOLDER, out)
            .process_group(0)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .status()
    };
    // What could not be started or done there is done here, with its error told.
    let _ = std::env::current_exe().and_then(start);
    finish(out)
}
