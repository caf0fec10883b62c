//! Output files: written completely or not at all, and replacing only regular files.
//!
//! A file is written under a temporary name in the same folder and then renamed, so that an
//! interrupted run leaves the previous file. A link is followed: its target is replaced, and the
//! link stays. A device or a pipe (`/dev/null`, `/dev/stdout`, `>(command)`) is written to
//! directly and never replaced; so is a file addressed as an open descriptor (`/dev/fd/3`).
//!
//! A new file has the permissions that the process gives to new files (`umask`); a file that
//! replaces another keeps that one's.

use std::fs::{File, FileType};
use std::io::{Error, ErrorKind, Read as _, Result, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

pub use potamoi_formats::files::{check, in_words, name_of, open, read, read_text, without_number};
use rustix::fs::{FlockOperation, Mode, OFlags};
use tempfile::NamedTempFile;

/// Prefix of the names of unfinished files, before random letters and digits.
const UNFINISHED: &str = ".potamoi-unfinished-";
/// Number of random letters and digits.
const RANDOM: usize = 8;
/// Maximum number of links followed in a row, as in Linux.
const MOST_LINKS: usize = 40;

/// Writes to a temporary name in the same folder and renames it; writes to devices and pipes
/// directly. If the reader of a pipe goes away, the rest is dropped silently, as by other tools.
///
/// # Errors
/// The folder does not exist or cannot be written, the path is a folder, socket or disk, or the
/// disk is full.
pub fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    let Some(place) = place(path)? else {
        return match into(path)?.write_all(bytes) {
            Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(()),
            done => done,
        };
    };
    let mut file = Unfinished::beside(&place)?;
    file.0.write_all(bytes)?;
    file.finish()
}

/// Checks that a file can be written here, before the work that produces it; creates its folder.
///
/// # Errors
/// Those of [`write()`], or the folder cannot be created.
pub fn prepare(path: &Path) -> Result<()> {
    match place(path)? {
        // Held from now on: whoever reads from a pipe sees no end before the result.
        None => into(path).map(|stream| {
            static HELD: Mutex<Vec<File>> = Mutex::new(vec![]);
            HELD.lock()
                .unwrap_or_else(PoisonError::into_inner)
                .push(stream);
        }),
        Some(place) => {
            std::fs::create_dir_all(folder(&place))?;
            Unfinished::beside(&place).map(drop)
        }
    }
}

/// The file that a path names, with all links resolved; `None` if the path names a stream, which
/// is written to directly.
///
/// # Errors
/// The path is a folder, a socket or a disk, or a link leads nowhere.
pub fn place(path: &Path) -> Result<Option<PathBuf>> {
    let found = match std::fs::metadata(path) {
        Ok(found) => found.file_type(),
        Err(error) if error.kind() == ErrorKind::NotFound => {
            let is_link = std::fs::symlink_metadata(path).is_ok();
            let leads_nowhere = Error::other("a link that leads nowhere: remove it first");
            return if is_link {
                Err(leads_nowhere)
            } else {
                Ok(Some(path.to_owned()))
            };
        }
        Err(error) => return Err(error),
    };
    if found.is_dir() {
        return Err(Error::new(ErrorKind::IsADirectory, "it is a folder"));
    }
    // Renaming over a file that is open would cut off whoever has it open.
    if is_stream(found) || (found.is_file() && leads_to_open_file(path)) {
        return Ok(None);
    }
    if !found.is_file() {
        return Err(Error::other("a socket or a disk, which is never written"));
    }
    let is_link = std::fs::symlink_metadata(path)?.file_type().is_symlink();
    Ok(Some(if is_link {
        std::fs::canonicalize(path)?
    } else {
        path.to_owned()
    }))
}

/// Whether a path, or a link on its way, names an open file descriptor of a process.
fn leads_to_open_file(path: &Path) -> bool {
    let mut path = std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    for _ in 0..MOST_LINKS {
        let is_in_proc = path.starts_with("/proc") && path.iter().any(|part| part == "fd");
        if is_in_proc || path.starts_with("/dev/fd") {
            return true;
        }
        let Ok(to) = std::fs::read_link(&path) else {
            return false;
        };
        path = folder(&path).join(to);
    }
    false
}

fn is_stream(kind: FileType) -> bool {
    use std::os::unix::fs::FileTypeExt as _;
    kind.is_char_device() || kind.is_fifo()
}

/// Opens a stream for writing without waiting for a reader.
fn into(path: &Path) -> Result<File> {
    let flags = OFlags::WRONLY | OFlags::APPEND | OFlags::NONBLOCK | OFlags::CLOEXEC;
    let opened = rustix::fs::open(path, flags, Mode::empty()).map_err(|error| {
        if error == rustix::io::Errno::NXIO {
            return Error::other("a FIFO that nobody reads");
        }
        error.into()
    })?;
    rustix::fs::fcntl_setfl(&opened, OFlags::APPEND)?;
    Ok(File::from(opened))
}

fn folder(path: &Path) -> &Path {
    match path.parent() {
        Some(p) if !p.as_os_str().is_empty() => p,
        _ => Path::new("."),
    }
}

/// A file that is being written, next to its final path. It is locked while its process lives. The
/// remains of a killed process are removed by the next one that writes into the same folder.
#[derive(Debug)]
pub struct Unfinished(NamedTempFile, PathBuf);

impl Unfinished {
    /// Creates the temporary file for `place`, which must not be a link. It gets the permissions
    /// of the file that it replaces, or those of a new file.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn beside(place: &Path) -> Result<Self> {
        // What the process hides from others is left out of these by the system.
        let file = Self::with_mode(place, 0o666)?;
        if let Ok(old) = std::fs::metadata(place) {
            file.0.as_file().set_permissions(old.permissions())?;
        }
        Ok(file)
    }

    /// As [`Unfinished::beside`], readable only by this user.
    ///
    /// # Errors
    /// Those of [`Unfinished::beside`].
    pub fn private_beside(place: &Path) -> Result<Self> {
        Self::with_mode(place, 0o600)
    }

    fn with_mode(place: &Path, mode: u32) -> Result<Self> {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = folder(place);
        sweep(folder, UNFINISHED, RANDOM);
        loop {
            let file = tempfile::Builder::new()
                .prefix(UNFINISHED)
                .rand_bytes(RANDOM)
                .permissions(std::fs::Permissions::from_mode(mode))
                .tempfile_in(folder)
                // The temporary name, which the library adds, would say nothing to a user.
                .map_err(|e| Error::from(e.kind()))?;
            // Where the file system knows no locks nothing is swept either.
            let _ = rustix::fs::flock(file.as_file(), FlockOperation::LockExclusive);
            // A sweep may have come between its making and its lock.
            if file.path().exists() {
                return Ok(Self(file, place.to_owned()));
            }
        }
    }

    /// Path of the unfinished file.
    #[must_use]
    pub fn path(&self) -> &Path {
        self.0.path()
    }

    /// Appends bytes.
    ///
    /// # Errors
    /// The disk is full or fails.
    pub fn write_all(&mut self, bytes: &[u8]) -> Result<()> {
        use std::io::Write as _;
        self.0.write_all(bytes)
    }

    /// Renames the file to its final path.
    ///
    /// # Errors
    /// The file cannot be renamed.
    pub fn finish(self) -> Result<()> {
        self.0.persist(&self.1).map_err(|e| e.error)?;
        Ok(())
    }
}

/// Removes files and folders that no process has locked and whose names are `prefix` followed by
/// `random` letters and digits.
pub fn sweep(folder: &Path, prefix: &str, random: usize) {
    let is_ours = |name: &str| {
        name.strip_prefix(prefix).is_some_and(|rest| {
            rest.len() == random && rest.bytes().all(|b| b.is_ascii_alphanumeric())
        })
    };
    let Ok(entries) = std::fs::read_dir(folder) else {
        return;
    };
    for entry in entries.flatten() {
        if !is_ours(&entry.file_name().to_string_lossy()) {
            continue;
        }
        let path = entry.path();
        let Ok(kind) = entry.file_type() else {
            continue;
        };
        if !kind.is_file() && !kind.is_dir() {
            continue;
        }
        let Ok(file) = File::open(&path) else {
            continue;
        };
        if rustix::fs::flock(&file, FlockOperation::NonBlockingLockExclusive).is_ok() {
            // What cannot be removed is found again by the next run.
            let _ = if kind.is_dir() {
                std::fs::remove_dir_all(&path)
            } else {
                std::fs::remove_file(&path)
            };
        }
    }
}

/// Whether a regular file has exactly these bytes.
#[must_use]
pub fn holds(path: &Path, bytes: &[u8]) -> bool {
    let Ok(file) = open(path) else {
        return false;
    };
    let mut found = vec![];
    let most = bytes.len() as u64 + 1;
    file.take(most).read_to_end(&mut found).is_ok() && found == bytes
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use std::os::unix::fs::symlink;

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

    #[test]
    fn links_are_written_through_and_stay() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("target"), "old").unwrap();
        symlink("target", at("link")).unwrap();
        symlink("nothing", at("dangling")).unwrap();
        write(&at("link"), b"new").unwrap();
        let kind = std::fs::symlink_metadata(at("link")).unwrap().file_type();
        assert!(kind.is_symlink());
        assert_eq!(std::fs::read(at("target")).unwrap(), b"new");
        for refuse in [write(&at("dangling"), b"x"), prepare(&at("dangling"))] {
            assert!(refuse.unwrap_err().to_string().contains("leads nowhere"));
        }
    }

    #[test]
    fn streams_are_written_into_and_never_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let null = folder.path().join("null");
        symlink("/dev/null", &null).unwrap();
        for path in [Path::new("/dev/null"), &null] {
            prepare(path).unwrap();
            write(path, b"x").unwrap();
            assert!(!std::fs::metadata(path).unwrap().is_file());
        }
        assert!(write(Path::new("/dev/full"), b"x").is_err());
        let pipe = folder.path().join("pipe");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status();
        assert!(made.unwrap().success());
        let error = prepare(&pipe).unwrap_err().to_string();
        assert_eq!(error, "a FIFO that nobody reads");
        let reads = OFlags::RDONLY | OFlags::NONBLOCK;
        let reader = rustix::fs::open(&pipe, reads, Mode::empty()).unwrap();
        write(&pipe, b"through").unwrap();
        let mut text = String::new();
        File::from(reader).read_to_string(&mut text).unwrap();
        assert_eq!(text, "through");
        // More than a pipe holds, to somebody who reads late.
        let whole = vec![b'y'; 1 << 20];
        let late = std::thread::spawn({
            let (pipe, mut found) = (pipe.clone(), vec![0; whole.len()]);
            move || {
                let mut reader = File::open(pipe).unwrap();
                std::thread::sleep(std::time::Duration::from_millis(100));
                reader.read_exact(&mut found).unwrap();
                found
            }
        });
        while let Err(error) = write(&pipe, &whole) {
            assert_eq!(error.to_string(), "a FIFO that nobody reads");
            std::thread::yield_now();
        }
        assert!(late.join().unwrap() == whole);
        // And to somebody who reads a part of it.
        let reader = std::thread::spawn({
            let pipe = pipe.clone();
            move || File::open(pipe).unwrap().read_exact(&mut [0; 10])
        });
        while prepare(&pipe).is_err() {
            std::thread::yield_now();
        }
        write(&pipe, &vec![b'x'; 1 << 20]).unwrap();
        reader.join().unwrap().unwrap();
    }

    /// A file that is open is written into by whatever name it has as that, and by its own name
    /// it is replaced, wherever it lies.
    #[test]
    fn open_files_are_written_into_by_their_numbers_alone() {
        use std::os::fd::AsRawFd as _;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("open");
        let file = File::create(&path).unwrap();
        let number = file.as_raw_fd();
        let link = folder.path().join("link");
        symlink(format!("/dev/fd/{number}"), &link).unwrap();
        let names = [
            format!("/dev/fd/{number}"),
            format!("/proc/self/fd/{number}"),
        ];
        for name in names.iter().map(Path::new).chain([link.as_path()]) {
            assert_eq!(place(name).unwrap(), None, "{}", name.display());
            write(name, b"x").unwrap();
        }
        assert_eq!(std::fs::read(&path).unwrap(), b"xxx");
        // A folder of devices has regular files too.
        for base in [folder.path(), Path::new("/dev/shm")] {
            let Ok(inside) = tempfile::tempdir_in(base) else {
                println!("{} cannot be written: not tried there", base.display());
                continue;
            };
            let file = inside.path().join("f");
            for text in ["first, longer", "second"] {
                write(&file, text.as_bytes()).unwrap();
                assert_eq!(std::fs::read_to_string(&file).unwrap(), text);
            }
        }
    }

    /// A new file has the permissions of any new file; a replaced one keeps its own.
    #[test]
    fn permissions_are_those_of_new_files_or_those_that_were() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let mode = |name: &str| std::fs::metadata(at(name)).unwrap().permissions().mode() & 0o777;
        File::create(at("plain")).unwrap();
        write(&at("new"), b"x").unwrap();
        assert_eq!(mode("new"), mode("plain"));
        for set in [0o600, 0o640, 0o755] {
            let permissions = std::fs::Permissions::from_mode(set);
            std::fs::set_permissions(at("new"), permissions).unwrap();
            write(&at("new"), b"y").unwrap();
            assert_eq!(mode("new"), set);
        }
        Unfinished::private_beside(&at("own"))
            .unwrap()
            .finish()
            .unwrap();
        assert_eq!(mode("own"), 0o600);
    }

    #[test]
    fn what_a_killed_run_left_is_swept_and_what_is_in_use_stays() {
        let folder = tempfile::tempdir().unwrap();
        let left = folder.path().join(".potamoi-unfinished-left1234");
        let others = [
            ".potamoi-notes",
            ".potamoi-unfinished-notes",
            ".potamoi-emitted",
        ];
        for path in others
            .map(|name| folder.path().join(name))
            .iter()
            .chain([&left])
        {
            std::fs::write(path, "half").unwrap();
        }
        let used = Unfinished::beside(&folder.path().join("f")).unwrap();
        assert!(!left.exists());
        assert!(others.iter().all(|name| folder.path().join(name).exists()));
        write(&folder.path().join("g"), b"x").unwrap();
        assert!(used.path().exists());
        used.finish().unwrap();
        assert!(folder.path().join("f").exists());
    }
}
