//! Listing and removal of what is kept.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use potamoi_base::outputs::FileError;
use schemars::JsonSchema;
use serde::Serialize;

use crate::ends_with_key;

/// Folders of what is kept, and what it is.
pub const KINDS: [(&str, &str); 4] = [
    ("models", "Verilog models, built for simulation"),
    ("work", "work counted on rendered frames"),
    ("synth", "results of synthesis"),
    ("mutants", "verdicts on mutants of the Verilog"),
];

/// One kept result.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Entry {
    /// Its folder: one of [`KINDS`].
    pub kind: &'static str,
    /// Name of its file or folder.
    pub name: String,
    /// Its size.
    pub bytes: u64,
    /// Age in seconds.
    pub age_seconds: u64,
}

/// What the folders of kept results hold.
#[derive(Debug, Clone, Default)]
pub struct Listing {
    /// Results, by kind and name.
    pub entries: Vec<Entry>,
    /// Other files in those folders, which are never removed.
    pub foreign: Vec<PathBuf>,
}

impl Listing {
    /// Lists the folders below `root`.
    ///
    /// # Errors
    /// A folder cannot be read.
    pub fn of(root: &Path) -> Result<Self, FileError> {
        let mut all = Self::default();
        for (kind, _) in KINDS {
            all.add(root, kind)?;
        }
        Ok(all)
    }

    /// Removes all results below `root`.
    ///
    /// # Errors
    /// One cannot be removed.
    pub fn remove(&self, root: &Path) -> Result<(), FileError> {
        let mut entries = self.entries.iter();
        entries.try_for_each(|entry| remove(&root.join(entry.kind).join(&entry.name)))
    }

    /// Entries of a kind and other files, told apart by name. An entry under construction has a name
    /// that begins with a dot.
    fn add(&mut self, root: &Path, kind: &'static str) -> Result<(), FileError> {
        let folder = root.join(kind);
        if !folder.is_dir() {
            return Ok(());
        }
        let fail = |e| FileError::new(&folder, e);
        let mut own = vec![];
        for entry in fs::read_dir(&folder).map_err(fail)? {
            let entry = entry.map_err(fail)?;
            let name = entry.file_name().to_string_lossy().into_owned();
            let Ok(metadata) = entry.metadata() else {
                continue;
            };
            if name.starts_with('.') {
                continue;
            }
            if !ends_with_key(&name) {
                self.foreign.push(entry.path());
                continue;
            }
            let made = metadata.modified().unwrap_or(SystemTime::UNIX_EPOCH);
            let age = SystemTime::now().duration_since(made).unwrap_or_default();
            own.push(Entry {
                kind,
                name,
                bytes: bytes(&entry.path()),
                age_seconds: age.as_secs(),
            });
        }
        own.sort_by(|a, b| a.name.cmp(&b.name));
        self.foreign.sort();
        self.entries.append(&mut own);
        Ok(())
    }
}

/// Size of a file, or of all files in a folder; links are not followed.
fn bytes(path: &Path) -> u64 {
    match fs::symlink_metadata(path) {
        Ok(found) if found.is_dir() => {
            let inside = fs::read_dir(path).into_iter().flatten().flatten();
            inside.map(|entry| bytes(&entry.path())).sum()
        }
        Ok(found) => found.len(),
        Err(_) => 0,
    }
}

fn remove(path: &Path) -> Result<(), FileError> {
    let is_folder = fs::symlink_metadata(path).is_ok_and(|found| found.is_dir());
    let removed = if is_folder {
        fs::remove_dir_all(path)
    } else {
        fs::remove_file(path)
    };
    removed.map_err(|e| FileError::new(path, e))
}
