//! Atomic replacement of one set of files by another.
//!
//! The new set is first written as a whole into a folder inside the old one, so that a full disk is
//! noticed there. Renaming that folder commits the new set. Its files are then moved into place one
//! by one, which needs no space, by a process that outlives a killed one ([`super::finisher`]). If
//! that is killed too, the next run completes the moves first. A manifest lists the files with
//! their hashes, which distinguishes files written or edited by others.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use potamoi_base::files::{holds, name_of, read, read_text, sweep};
use serde::{Deserialize, Serialize};

use crate::failure::Failure;
use crate::files::FileError;

/// List of the files of an emission.
pub(super) const MANIFEST: &str = "manifest.json";
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
pub(super) type Set = BTreeMap<String, String>;

#[derive(Debug, Serialize, Deserialize)]
struct Manifest {
    format_version: u32,
    configuration: String,
    /// blake3 hash of each file, by path in the folder.
    files: BTreeMap<String, String>,
}

/// Replaces the files of an earlier emission. Returns the paths of removed files. `finish` runs
/// [`finish`].
///
/// # Errors
/// Files of those names exist that no emission wrote, or that were edited since, unless
/// `overwrite`; a file cannot be written, in which case the old set remains.
pub(super) fn replace(
    out: &Path,
    set: &Set,
    configuration: &str,
    overwrite: bool,
    finish: &dyn Fn(&Path) -> Result<(), Failure>,
) -> Result<Vec<String>, Failure> {
    fs::create_dir_all(out).map_err(|e| FileError::new(out, e))?;
    finish(out)?;
    sweep(out, WRITING, RANDOM);
    let old = manifest_of(out);
    let foreign = foreign(out, set, &old)?;
    if !foreign.is_empty() && !overwrite {
        return Err(Failure::Usage(format!(
            "{} holds files that this command did not write, or that were edited since: {}; name \
             another folder, or replace them with --overwrite",
            out.display(),
            foreign.join(", ")
        )));
    }
    let gone: Vec<String> = old
        .keys()
        .filter(|path| !set.contains_key(*path) && out.join(path).exists())
        .cloned()
        .collect();
    write(out, set, configuration, &gone)?;
    finish(out)?;
    Ok(gone)
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
fn foreign(out: &Path, set: &Set, old: &BTreeMap<String, String>) -> Result<Vec<String>, Failure> {
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
            return Err(Failure::Usage(format!(
                "{} is {} and is never replaced: name another folder",
                path.display(),
                if found.file_type().is_symlink() {
                    "a link"
                } else {
                    what
                }
            )));
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
fn folders_are_here(out: &Path, name: &str) -> Result<(), Failure> {
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
            return Err(Failure::Usage(format!(
                "{} is {what}: the files of the unit would not stay in {}; name another folder",
                path.display(),
                out.display()
            )));
        }
    }
    Ok(())
}

fn hash(bytes: &[u8]) -> String {
    blake3::hash(bytes).to_hex().to_string()
}

/// Writes the whole set beside the old one, and commits it.
fn write(out: &Path, set: &Set, configuration: &str, gone: &[String]) -> Result<(), Failure> {
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
pub(super) fn is_finished(out: &Path) -> bool {
    !out.join(WHOLE).is_dir()
}

/// Moves a committed set into place, from this run or a killed one.
///
/// # Errors
/// A file cannot be renamed or removed.
pub(super) fn finish(out: &Path) -> Result<(), Failure> {
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn set(names: &[&str], text: &str) -> Set {
        names
            .iter()
            .map(|n| ((*n).to_owned(), format!("{text} {n}\n")))
            .collect()
    }

    fn replaced(
        out: &Path,
        set: &Set,
        hash: &str,
        overwrite: bool,
    ) -> Result<Vec<String>, Failure> {
        replace(out, set, hash, overwrite, &finish)
    }

    /// All files of a folder, except the manifest.
    fn content(out: &Path) -> Set {
        let mut names = vec![];
        below(out, out, &mut names).unwrap();
        let names = names.iter().map(|n| n.display().to_string());
        names
            .filter(|n| n != MANIFEST)
            .map(|n| (n.clone(), fs::read_to_string(out.join(&n)).unwrap()))
            .collect()
    }

    /// A folder that is a link points elsewhere: nothing is written or removed there.
    #[test]
    fn folders_that_are_links_are_not_followed() {
        let folder = tempfile::tempdir().unwrap();
        let [out, other] = ["o", "elsewhere"].map(|name| folder.path().join(name));
        for path in [&out, &other] {
            fs::create_dir(path).unwrap();
        }
        std::os::unix::fs::symlink(&other, out.join("unit")).unwrap();
        fs::write(out.join("tb"), "a file").unwrap();
        for (name, said) in [("unit/a.v", "is a link"), ("tb/a.v", "is no folder")] {
            for overwrite in [false, true] {
                let error = replaced(&out, &set(&[name], "new"), "c", overwrite).unwrap_err();
                assert!(error.to_string().contains(said), "{error}");
            }
        }
        assert_eq!(fs::read_dir(&other).unwrap().count(), 0);
    }

    #[test]
    fn a_set_replaces_another_and_leaves_the_rest() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("o");
        let (old, new) = (set(&["u/a.v", "u/b.v"], "old"), set(&["u/a.v", "c"], "new"));
        replaced(&out, &old, "1", false).unwrap();
        fs::write(out.join("u/mine.v"), "mine").unwrap();
        assert_eq!(replaced(&out, &new, "2", false).unwrap(), ["u/b.v"]);
        let mut expected = new.clone();
        expected.insert("u/mine.v".to_owned(), "mine".to_owned());
        assert_eq!(content(&out), expected);
        assert!(replaced(&out, &new, "2", false).unwrap().is_empty());
    }

    /// A manifest that no emission wrote is a user's file.
    #[test]
    fn a_foreign_manifest_stays() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path();
        let new = set(&["a.v"], "new");
        let manifest = out.join(MANIFEST);
        let write = |overwrite| replaced(out, &new, "1", overwrite).map_err(|e| e.to_string());
        fs::write(&manifest, "{\"mine\": 1}").unwrap();
        assert!(write(false).unwrap_err().contains(MANIFEST));
        assert_eq!(fs::read_to_string(&manifest).unwrap(), "{\"mine\": 1}");
        write(true).unwrap();
        write(false).unwrap();

        fs::remove_file(&manifest).unwrap();
        fs::write(out.join("victim"), "victim").unwrap();
        std::os::unix::fs::symlink("victim", &manifest).unwrap();
        for overwrite in [false, true] {
            assert!(write(overwrite).unwrap_err().contains("a link"));
        }
        assert_eq!(fs::read_to_string(&manifest).unwrap(), "victim");
        fs::remove_file(&manifest).unwrap();
        let fifo = std::process::Command::new("mkfifo").arg(&manifest).status();
        assert!(fifo.unwrap().success());
        for overwrite in [false, true] {
            assert!(write(overwrite).unwrap_err().contains("never replaced"));
        }
    }

    #[test]
    fn edited_and_foreign_files_stay_unless_told_otherwise() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path();
        let (old, new) = (set(&["a.v", "b.v"], "old"), set(&["a.v", "c.v"], "new"));
        fs::write(out.join("c.v"), "foreign").unwrap();
        replaced(out, &old, "1", false).unwrap();
        fs::write(out.join("b.v"), "edited").unwrap();
        let before = content(out);
        let said = replaced(out, &new, "2", false).unwrap_err().to_string();
        assert!(said.contains("b.v") && said.contains("c.v") && said.contains("--overwrite"));
        assert!(!said.contains("a.v"), "{said}");
        assert_eq!(content(out), before);
        replaced(out, &new, "2", true).unwrap();
        assert_eq!(content(out), new);
    }

    #[test]
    fn a_run_that_was_cut_off_left_the_old_set_or_is_finished() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path();
        let (old, new) = (set(&["a.v", "b.v"], "old"), set(&["a.v", "c.v"], "new"));
        replaced(out, &old, "1", false).unwrap();
        // Cut off while it was written.
        fs::create_dir(out.join(".potamoi-emit-left1234")).unwrap();
        fs::write(out.join(".potamoi-emit-left1234/a.v"), "half").unwrap();
        replaced(out, &old, "1", false).unwrap();
        assert_eq!(content(out), old);
        // Cut off after one of its files had its place.
        write(out, &new, "2", &["b.v".to_owned()]).unwrap();
        fs::rename(out.join(WHOLE).join(NEW).join("a.v"), out.join("a.v")).unwrap();
        finish(out).unwrap();
        assert_eq!(content(out), new);
        assert_eq!(manifest_of(out).len(), 2);
        // Cut off when nothing but the folder was left to remove.
        fs::create_dir(out.join(WHOLE)).unwrap();
        replaced(out, &new, "2", false).unwrap();
        assert_eq!(content(out), new);
    }

    /// Until all files are in place the old manifest remains: the new one is moved last.
    #[test]
    fn the_manifest_takes_its_place_last() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path();
        let (old, new) = (set(&["a.v", "z.v"], "old"), set(&["a.v", "z.v"], "new"));
        replaced(out, &old, "1", false).unwrap();
        let before = fs::read_to_string(out.join(MANIFEST)).unwrap();
        write(out, &new, "2", &[]).unwrap();
        // The last file cannot take its place.
        fs::remove_file(out.join("z.v")).unwrap();
        fs::create_dir(out.join("z.v")).unwrap();
        finish(out).unwrap_err();
        assert_eq!(fs::read_to_string(out.join("a.v")).unwrap(), new["a.v"]);
        assert_eq!(fs::read_to_string(out.join(MANIFEST)).unwrap(), before);
        fs::remove_dir(out.join("z.v")).unwrap();
        finish(out).unwrap();
        assert_eq!(content(out), new);
        assert_ne!(fs::read_to_string(out.join(MANIFEST)).unwrap(), before);
    }

    #[test]
    fn devices_and_links_are_never_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path();
        std::os::unix::fs::symlink("victim", out.join("a.v")).unwrap();
        for overwrite in [false, true] {
            let said = replaced(out, &set(&["a.v"], "new"), "1", overwrite).unwrap_err();
            assert!(said.to_string().contains("is a link"), "{said}");
        }
        fs::remove_file(out.join("a.v")).unwrap();
        let pipe = out.join("a.v");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        for overwrite in [false, true] {
            let said = replaced(out, &set(&["a.v"], "new"), "1", overwrite).unwrap_err();
            assert!(said.to_string().contains("a FIFO"), "{said}");
        }
    }

    #[test]
    fn a_manifest_reaches_no_file_outside() {
        for bad in ["../a", "/a", "a/../../b"] {
            assert!(!is_inside(bad), "{bad}");
        }
        assert!(is_inside("gathering_unit/a.v"));
    }
}
