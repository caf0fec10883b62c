//! Atomic replacement of one set of files by another.
//!
//! The new set is first written as a whole into a folder inside the old one, so that a full disk is
//! noticed there. Renaming that folder commits the new set. Its files are then moved into place one
//! by one, which needs no space, by a process that outlives a killed one ([`finish_apart`]). If
//! that is killed too, the next run completes the moves first. A manifest lists the files with
//! their hashes, which distinguishes files written or edited by others.

mod finisher;
#[cfg(test)]
mod tests;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::files::{holds, name_of, read, read_text, sweep};
use crate::outputs::FileError;

pub use finisher::{finish_apart, finish_if_asked};

/// List of the files of an emission.
const MANIFEST: &str = "manifest.json";
/// Prefix of the folder of an uncommitted set, before random letters and digits.
const WRITING: &str = ".potamoi-emit-";
/// Number of random letters and digits.
const RANDOM: usize = 8;
/// Folder of a committed set.
const WHOLE: &str = ".potamoi-emitted";
/// List of removed files, in that folder.
const GONE: &str = "gone.json";
const NEW: &str = "new";
const FORMAT_VERSION: u32 = 1;
/// Size limit of a manifest, and of a file of a set, in bytes.
const LARGEST: u64 = 256 << 20;

/// Files by their path below the folder.
pub type Set = BTreeMap<String, String>;

/// Why a set cannot take the place of another.
#[derive(Debug, Error)]
pub enum FileSetError {
    /// A file or folder cannot be written.
    #[error(transparent)]
    File(#[from] FileError),
    /// Files would be lost that no emission wrote, or that were edited.
    #[error(
        "{} holds files that this command did not write, or that were edited since: {}; name \
         another folder, or replace them with --overwrite",
        folder.display(),
        names.join(", ")
    )]
    Foreign {
        /// The folder of the set.
        folder: PathBuf,
        /// The files, by path in the folder.
        names: Vec<String>,
    },
    /// Folders of an earlier emission that this one has no file in.
    #[error(
        "{} has {} of an earlier emission, which this one does not write: name another folder, or \
         give --overwrite, which removes them",
        folder.display(),
        names.join(", ")
    )]
    Others {
        /// The folder of the set.
        folder: PathBuf,
        /// The folders.
        names: Vec<String>,
    },
    /// A file's place is taken by a link, a device or a folder.
    #[error("{} is {what} and is never replaced: name another folder", path.display())]
    NeverReplaced {
        /// The place.
        path: PathBuf,
        /// Kind of the entry that is there.
        what: &'static str,
    },
    /// A folder's place is taken by a link or a file.
    #[error(
        "{} is {what}: the files of the unit would not stay in {}; name another folder",
        path.display(),
        folder.display()
    )]
    NoFolder {
        /// The place.
        path: PathBuf,
        /// Kind of the entry that is there.
        what: &'static str,
        /// The folder of the set.
        folder: PathBuf,
    },
}

#[derive(Debug, Serialize, Deserialize)]
struct Manifest {
    format_version: u32,
    configuration: String,
    /// blake3 hash of each file, by path in the folder.
    files: BTreeMap<String, String>,
}

/// Replaces the files of an earlier emission. Returns the paths of removed files. `finish` moves a
/// committed set into place, as [`finish_apart`] does.
///
/// # Errors
/// Files of those names exist that no emission wrote, or that were edited since, or a folder of the
/// earlier emission would go, unless `overwrite`; a file cannot be written, in which case the old set remains.
pub fn replace(
    out: &Path,
    set: &Set,
    configuration: &str,
    overwrite: bool,
    finish: &dyn Fn(&Path) -> Result<(), FileSetError>,
) -> Result<Vec<String>, FileSetError> {
    fs::create_dir_all(out).map_err(|e| FileError::new(out, e))?;
    finish(out)?;
    sweep(out, WRITING, RANDOM);
    let old = manifest_of(out);
    let foreign = foreign(out, set, &old)?;
    if !foreign.is_empty() && !overwrite {
        return Err(FileSetError::Foreign {
            folder: out.to_owned(),
            names: foreign,
        });
    }
    let gone: Vec<String> = old
        .keys()
        .filter(|path| !set.contains_key(*path) && out.join(path).exists())
        .cloned()
        .collect();
    let folders = whole_folders(&gone, set);
    if !folders.is_empty() && !overwrite {
        return Err(FileSetError::Others {
            folder: out.to_owned(),
            names: folders,
        });
    }
    write(out, set, configuration, &gone)?;
    finish(out)?;
    Ok(gone)
}

/// First folders of removed files that the set has no file in: another emission's parts.
fn whole_folders(gone: &[String], set: &Set) -> Vec<String> {
    let first = |path: &str| Some(path.split_once('/')?.0.to_owned());
    let left: BTreeSet<String> = set.keys().filter_map(|path| first(path)).collect();
    let gone: BTreeSet<String> = gone.iter().filter_map(|path| first(path)).collect();
    gone.difference(&left).cloned().collect()
}

/// Files of the old manifest; empty where none is readable.
fn manifest_of(out: &Path) -> BTreeMap<String, String> {
    let text = read_text(&out.join(MANIFEST), LARGEST).ok();
    let manifest: Option<Manifest> = text.and_then(|text| serde_json::from_str(&text).ok());
    let files = manifest.map(|m| m.files).unwrap_or_default();
    files
        .into_iter()
        .filter(|(path, _)| is_inside(path))
        .collect()
}

/// Whether a relative path stays below its folder.
fn is_inside(path: &str) -> bool {
    let mut parts = Path::new(path).components();
    parts.all(|part| matches!(part, std::path::Component::Normal(_)))
}

/// Existing files in the set's places that differ from an emission's output.
fn foreign(
    out: &Path,
    set: &Set,
    old: &BTreeMap<String, String>,
) -> Result<Vec<String>, FileSetError> {
    let mut foreign = vec![];
    let is_ours = |path: &Path| {
        let text = read_text(path, LARGEST).ok();
        text.is_some_and(|text| serde_json::from_str::<Manifest>(&text).is_ok())
    };
    let names = set
        .keys()
        .chain(old.keys().filter(|p| !set.contains_key(*p)))
        .map(String::as_str)
        .chain([MANIFEST]);
    for name in names {
        folders_are_here(out, name)?;
        let path = out.join(name);
        let Ok(found) = fs::symlink_metadata(&path) else {
            continue;
        };
        if let Some(what) = name_of(found.file_type()) {
            let is_link = found.file_type().is_symlink();
            let what = if is_link { "a link" } else { what };
            return Err(FileSetError::NeverReplaced { path, what });
        }
        let is_same = set
            .get(name)
            .is_some_and(|text| holds(&path, text.as_bytes()));
        let is_listed = || {
            let bytes = read(&path, LARGEST).ok().flatten();
            let hash = bytes.map(|bytes| hash(&bytes));
            hash.is_some() && hash.as_ref() == old.get(name)
        };
        let is_manifest = name == MANIFEST && is_ours(&path);
        if !is_same && !is_manifest && !is_listed() {
            foreign.push(name.to_owned());
        }
    }
    Ok(foreign)
}

/// Checks that the folders of a file in the set are real folders, not links.
fn folders_are_here(out: &Path, name: &str) -> Result<(), FileSetError> {
    let inner = Path::new(name).ancestors().skip(1);
    for folder in inner.filter(|folder| *folder != Path::new("")) {
        let path = out.join(folder);
        let Ok(found) = fs::symlink_metadata(&path) else {
            continue;
        };
        if !found.is_dir() {
            let what = if found.file_type().is_symlink() {
                "a link"
            } else {
                "no folder"
            };
            return Err(FileSetError::NoFolder {
                path,
                what,
                folder: out.to_owned(),
            });
        }
    }
    Ok(())
}

fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

/// Writes the whole set beside the old one, and commits it.
fn write(out: &Path, set: &Set, configuration: &str, gone: &[String]) -> Result<(), FileSetError> {
    let fail = |path: &Path| {
        let path = path.to_owned();
        move |e| FileError::new(&path, e)
    };
    let folder = tempfile::Builder::new()
        .prefix(WRITING)
        .rand_bytes(RANDOM)
        .tempdir_in(out)
        .map_err(|e| FileError::new(out, e.kind().into()))?;
    // Held until the set is whole: the next run sweeps what nobody holds.
    let lock = fs::File::open(folder.path()).map_err(fail(out))?;
    let _ = rustix::fs::flock(&lock, rustix::fs::FlockOperation::LockExclusive);
    let manifest = Manifest {
        format_version: FORMAT_VERSION,
        configuration: configuration.to_owned(),
        files: set
            .iter()
            .map(|(p, text)| (p.clone(), hash(text.as_bytes())))
            .collect(),
    };
    let text =
        |value: Result<String, serde_json::Error>| value.map_err(|e| FileError::new(out, e.into()));
    let listed = text(serde_json::to_string_pretty(&manifest))? + "\n";
    let new = folder.path().join(NEW);
    let all = set
        .iter()
        .map(|(path, text)| (path.as_str(), text.as_str()));
    for (name, text) in all.chain([(MANIFEST, listed.as_str())]) {
        let path = new.join(name);
        let place = out.join(name);
        fs::create_dir_all(path.parent().unwrap_or(&new)).map_err(fail(&place))?;
        fs::write(&path, text).map_err(fail(&place))?;
        // Folders are made before the decision too.
        fs::create_dir_all(place.parent().unwrap_or(out)).map_err(fail(&place))?;
    }
    let path = folder.path().join(GONE);
    fs::write(&path, text(serde_json::to_string(gone))?).map_err(fail(out))?;
    let whole = out.join(WHOLE);
    fs::rename(folder.path(), &whole).map_err(fail(&whole))?;
    Ok(())
}

/// Whether no committed set still waits to be moved into place.
fn is_finished(out: &Path) -> bool {
    !out.join(WHOLE).is_dir()
}

/// Moves a committed set into place, from this run or a killed one.
///
/// # Errors
/// A file cannot be renamed or removed.
fn finish(out: &Path) -> Result<(), FileSetError> {
    if is_finished(out) {
        return Ok(());
    }
    let whole = out.join(WHOLE);
    let new = whole.join(NEW);
    let mut names = vec![];
    // It is gone where all had their places already.
    if new.is_dir() {
        below(&new, &new, &mut names).map_err(|e| FileError::new(&whole, e))?;
    }
    // The manifest is last: until then the old one may call the files edited.
    names.sort_by_key(|name| (name == Path::new(MANIFEST), name.clone()));
    for name in names {
        let place = out.join(&name);
        fs::create_dir_all(place.parent().unwrap_or(out)).map_err(|e| FileError::new(&place, e))?;
        fs::rename(new.join(&name), &place).map_err(|e| FileError::new(&place, e))?;
    }
    let gone = read_text(&whole.join(GONE), LARGEST).ok();
    let gone: Vec<String> = gone
        .and_then(|text| serde_json::from_str(&text).ok())
        .unwrap_or_default();
    for name in gone.iter().filter(|name| is_inside(name)) {
        match fs::remove_file(out.join(name)) {
            Err(e) if e.kind() != std::io::ErrorKind::NotFound => {
                return Err(FileError::new(&out.join(name), e).into());
            }
            _ => {}
        }
    }
    fs::remove_dir_all(&whole).map_err(|e| FileError::new(&whole, e))?;
    Ok(())
}

/// Paths of all files in a folder, relative to `root`.
fn below(root: &Path, folder: &Path, found: &mut Vec<PathBuf>) -> std::io::Result<()> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            below(root, &path, found)?;
        } else if let Ok(name) = path.strip_prefix(root) {
            found.push(name.to_owned());
        }
    }
    Ok(())
}
