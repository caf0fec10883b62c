//! Files read through a path: itself, those in it, and those that descriptions name.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};

use potamoi_formats::document::{self, Value};

/// Depth to which files named in descriptions are followed.
const DEPTH: u32 = 5;
/// Larger descriptions, in bytes, are not searched for file names.
const LARGEST: u64 = 64 << 20;
/// Largest number of files searched in an input folder.
const MOST: usize = 100_000;

/// Device and inode of an existing regular file.
#[must_use]
pub fn regular(path: &Path) -> Option<(u64, u64)> {
    let found = fs::metadata(path).ok()?;
    found.is_file().then(|| (found.dev(), found.ino()))
}

/// All files read through a path, as far as known: itself, the files in it if it is a folder, and
/// those named in a description.
#[must_use]
pub fn files_of(path: &Path) -> BTreeSet<(u64, u64)> {
    found_through(path).into_keys().collect()
}

/// The same files by path, as they are reached from that path; a file with several names has one of them.
#[must_use]
pub fn paths_of(path: &Path) -> BTreeSet<PathBuf> {
    found_through(path).into_values().collect()
}

fn found_through(path: &Path) -> Found {
    let mut found = Found::new();
    add(path, DEPTH, &mut found);
    found
}

/// Paths of files by device and inode.
type Found = BTreeMap<(u64, u64), PathBuf>;

/// File of times that a trajectory is read with, where it lies beside it.
const TIMES: &str = "times.txt";

/// Adds the files read through a path, at this depth of descriptions and folders.
fn add(path: &Path, depth: u32, found: &mut Found) {
    if path.is_dir() {
        let entries = fs::read_dir(path).into_iter().flatten().flatten();
        for entry in entries {
            if depth == 0 || found.len() > MOST {
                return;
            }
            add(&entry.path(), depth - 1, found);
        }
        return;
    }
    let Some(file) = regular(path) else {
        return;
    };
    if found.contains_key(&file) {
        return;
    }
    found.insert(file, path.to_owned());
    if depth == 0 {
        return;
    }
    add(&path.with_file_name(TIMES), 0, found);
    let is_text = |ending: &str| {
        path.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case(ending))
    };
    if !is_text("toml") && !is_text("json") {
        return;
    }
    let Ok(Some(bytes)) = potamoi_base::files::read(path, LARGEST) else {
        return;
    };
    let folder = path.parent().unwrap_or(Path::new(""));
    let value = match is_text("toml") {
        true => document::toml(&bytes),
        false => document::json(&bytes),
    };
    let mut names = vec![];
    value.iter().for_each(|value| texts(value, &mut names));
    for name in names {
        let named = folder.join(&name);
        add(&named, depth - 1, found);
        // Frames of a path are named without their ending.
        add(&folder.join(name + ".png"), 0, found);
    }
}

/// All strings in a value.
fn texts(value: &Value, found: &mut Vec<String>) {
    match value {
        Value::Text(text) if text.len() < 4096 => found.push(text.to_string()),
        Value::List(items) => items.iter().for_each(|item| texts(item, found)),
        Value::Map(fields) => fields.iter().for_each(|(_, value)| texts(value, found)),
        _ => {}
    }
}
