//! Cache folder between runs, and folders of unfinished work.
//!
//! Models are loaded from the folder as code. It is therefore used only if no other user can write
//! it or its entries. Unfinished work is in a [`Scratch`], which is locked while its owner lives,
//! so that the next run can tell leftovers of a killed run from work in progress.

use crate::Error;
use rustix::fs::FlockOperation;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs::{self, DirBuilder, File, Metadata};
use std::os::unix::fs::{DirBuilderExt as _, MetadataExt as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Folder of the built models inside the root.
pub(crate) const MODELS: &str = "models";

/// Prefixes of the names of unfinished work.
pub(crate) const BUILDING: &str = ".building-";
pub(crate) const TRASH: &str = ".trash-";
const SCRATCH: &str = "potamoi-scratch-";

/// Permission bits of folders: owner only.
const PRIVATE: u32 = 0o700;
/// Permission bits that let others write.
const OTHERS_WRITE: u32 = 0o022;

/// The cache root: `POTAMOI_CACHE`, else `potamoi` in `XDG_CACHE_HOME` or in `.cache` of `HOME`.
///
/// # Errors
/// [`Error::NoCacheDir`]: none of the three is set.
pub fn root() -> Result<PathBuf, Error> {
    root_of(&|name| std::env::var_os(name).filter(|v| !v.is_empty()))
}

fn root_of(set: &dyn Fn(&str) -> Option<OsString>) -> Result<PathBuf, Error> {
    if let Some(cache) = set("POTAMOI_CACHE") {
        return Ok(cache.into());
    }
    let absolute = |name| set(name).map(PathBuf::from).filter(|p| p.is_absolute());
    absolute("XDG_CACHE_HOME")
        .or_else(|| absolute("HOME").map(|home| home.join(".cache")))
        .map(|base| base.join("potamoi"))
        .ok_or(Error::NoCacheDir)
}

/// A folder in the root, such as `models`: created if missing, with permissions for the user
/// only, and swept.
///
/// # Errors
/// As [`root`] and [`claim`].
pub fn folder(kind: &str) -> Result<PathBuf, Error> {
    let root = claim(&root()?)?;
    claim(&root.join(kind))
}

/// Creates a cache folder if missing, checks it, and removes unfinished work of killed runs.
/// Returns its canonical path.
///
/// # Errors
/// [`Error::Io`]; [`Error::Untrusted`] where another user owns it or can write it.
pub fn claim(folder: &Path) -> Result<PathBuf, Error> {
    DirBuilder::new()
        .recursive(true)
        .mode(PRIVATE)
        .create(folder)
        .map_err(|e| Error::NoFolder {
            path: folder.to_owned(),
            reason: e.to_string(),
        })?;
    let found = fs::canonicalize(folder).map_err(|e| Error::io("find the folder", folder, &e))?;
    let metadata = fs::metadata(&found).map_err(|e| Error::io("read", folder, &e))?;
    distrust(&metadata).map_or(Ok(()), |problem| {
        Err(Error::Untrusted {
            path: folder.to_owned(),
            problem,
            is_own: metadata.uid() == rustix::process::geteuid().as_raw(),
        })
    })?;
    static SWEPT: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let mut swept = SWEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if swept.insert(found.clone()) {
        sweep(&found, &[BUILDING, TRASH]);
    }
    Ok(found)
}

/// Why a file or folder may hold data of other users; `None` if only this user can write it.
#[must_use]
pub(crate) fn distrust(metadata: &Metadata) -> Option<String> {
    let user = rustix::process::geteuid().as_raw();
    let is_link = metadata.file_type().is_symlink();
    let mode = metadata.mode() & 0o7777;
    distrust_of(metadata.uid(), user, (!is_link).then_some(mode))
}

/// As [`distrust`], by owner, user and permission bits; links have no bits.
fn distrust_of(owner: u32, user: u32, mode: Option<u32>) -> Option<String> {
    if owner != user {
        return Some(format!(
            "it belongs to user {owner}, and this is user {user}"
        ));
    }
    let mode = mode.filter(|mode| mode & OTHERS_WRITE != 0)?;
    Some(format!(
        "others than its owner can write it (mode {mode:04o})"
    ))
}

/// Whether a file or folder in a claimed one belongs to this user, is writable by no other, and is
/// no link.
pub fn is_own(path: &Path) -> bool {
    fs::symlink_metadata(path)
        .is_ok_and(|found| !found.file_type().is_symlink() && distrust(&found).is_none())
}

/// A folder of unfinished work, removed when dropped, or by the next run if its process is killed.
#[derive(Debug)]
pub struct Scratch {
    folder: tempfile::TempDir,
    /// Lock held while the process lives.
    _lock: Option<File>,
}

impl Scratch {
    /// Creates one in the system's temporary folder.
    ///
    /// # Errors
    /// It cannot be created.
    pub fn temporary() -> std::io::Result<Self> {
        static SWEPT: Mutex<bool> = Mutex::new(false);
        let folder = std::env::temp_dir();
        let mut swept = SWEPT.lock().unwrap_or_else(PoisonError::into_inner);
        if !std::mem::replace(&mut *swept, true) {
            sweep(&folder, &[SCRATCH]);
        }
        Self::within(&folder, SCRATCH)
    }

    pub(crate) fn within(parent: &Path, prefix: &str) -> std::io::Result<Self> {
        loop {
            let folder = tempfile::Builder::new().prefix(prefix).tempdir_in(parent)?;
            let lock = File::open(folder.path())?;
            // Where the file system knows no locks nothing is swept either.
            let lock = match rustix::fs::flock(&lock, FlockOperation::LockExclusive) {
                Ok(()) => Some(lock),
                Err(_) => None,
            };
            // A sweep may have come between its making and its lock.
            if folder.path().is_dir() {
                return Ok(Self {
                    folder,
                    _lock: lock,
                });
            }
        }
    }

    /// Its path.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.folder.path()
    }
}

/// Removes unfinished work of dead processes.
fn sweep(folder: &Path, prefixes: &[&str]) {
    let Ok(entries) = fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let path = entry.path();
        if !prefixes.iter().any(|prefix| name.starts_with(prefix)) || !is_own(&path) {
            continue;
        }
        let Ok(file) = File::open(&path) else {
            continue;
        };
        if rustix::fs::flock(&file, FlockOperation::NonBlockingLockExclusive).is_ok() {
            // What cannot be removed is found again by the next run.
            let _ = fs::remove_dir_all(&path);
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::os::unix::fs::PermissionsExt as _;

    #[test]
    fn the_root_follows_the_environment() {
        let with = |pairs: &'static [(&str, &str)]| {
            root_of(&|n| pairs.iter().find(|p| p.0 == n).map(|p| p.1.into()))
        };
        let all = &[
            ("POTAMOI_CACHE", "/c"),
            ("XDG_CACHE_HOME", "/x"),
            ("HOME", "/h"),
        ];
        assert_eq!(with(all).unwrap(), PathBuf::from("/c"));
        let xdg = &[("XDG_CACHE_HOME", "/x"), ("HOME", "/h")];
        assert_eq!(with(xdg).unwrap(), PathBuf::from("/x/potamoi"));
        let home = with(&[("XDG_CACHE_HOME", "x"), ("HOME", "/h")]).unwrap();
        assert_eq!(home, PathBuf::from("/h/.cache/potamoi"));
        assert_eq!(with(&[]).unwrap_err(), Error::NoCacheDir);
        assert_eq!(with(&[("HOME", "h")]).unwrap_err(), Error::NoCacheDir);
    }

    #[test]
    fn what_others_own_or_can_write_is_not_trusted() {
        let says = |owner, mode| distrust_of(owner, 1000, mode).unwrap_or_default();
        for mode in [Some(0o700), Some(0o755), None] {
            assert_eq!(says(1000, mode), "");
            for other in [0, 1001] {
                assert!(says(other, mode).contains(&format!("belongs to user {other}")));
            }
        }
        for mode in [0o720, 0o702, 0o1777] {
            assert!(says(1000, Some(mode)).contains("can write it"), "{mode:o}");
        }
    }

    #[test]
    fn folders_are_the_users_own() {
        let outer = tempfile::tempdir().unwrap();
        let folder = outer.path().join("a/b");
        let set = |mode| fs::set_permissions(&folder, fs::Permissions::from_mode(mode)).unwrap();
        claim(&folder).unwrap();
        let mode = fs::metadata(&folder).unwrap().mode() & 0o7777;
        assert_eq!(mode, PRIVATE);
        for open in [0o720, 0o702, 0o777, 0o1777] {
            set(open);
            let error = claim(&folder).unwrap_err();
            assert!(
                matches!(error, Error::Untrusted { is_own: true, .. }),
                "{error}"
            );
            assert!(error.to_string().contains("chmod go-w"), "{error}");
        }
        set(0o755);
        claim(&folder).unwrap();
    }

    #[test]
    fn what_a_killed_run_left_is_swept_and_what_is_in_use_stays() {
        let cache = tempfile::tempdir().unwrap();
        let used = Scratch::within(cache.path(), BUILDING).unwrap();
        let left = cache.path().join(".building-left");
        fs::create_dir_all(left.join("deep")).unwrap();
        let other = cache.path().join("m-0");
        fs::create_dir(&other).unwrap();
        claim(cache.path()).unwrap();
        assert!(!left.exists());
        assert!(used.path().is_dir() && other.is_dir());
        let path = used.path().to_owned();
        drop(used);
        assert!(!path.exists());
    }
}
