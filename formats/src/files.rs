//! Input files: regular ones, of bounded size.
//!
//! Every reader opens its files here, so that a pipe, a device or a folder in a file's place is
//! refused in the same words, and nothing waits for a pipe that nobody writes.

use std::fs::{File, FileType};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::Path;

/// Opens a regular file.
///
/// # Errors
/// The file cannot be read, or it is no regular file: pipes and devices have no end, and opening
/// one may wait for ever or act on hardware, so that neither is opened.
pub fn open(path: &Path) -> Result<File> {
    check(std::fs::metadata(path).map_err(in_words)?.file_type())?;
    let file = File::open(path).map_err(in_words)?;
    // What is opened may have been put there since.
    check(file.metadata()?.file_type())?;
    Ok(file)
}

/// An error of the operating system in a user's words, without its number; its kind stays. Other errors
/// stay as they are.
#[must_use]
pub fn in_words(error: Error) -> Error {
    if error.raw_os_error().is_none() {
        return error;
    }
    let kind = error.kind();
    let words = match kind {
        ErrorKind::NotFound => "there is no file or folder of that name",
        ErrorKind::PermissionDenied => "its permissions do not allow it",
        ErrorKind::IsADirectory => "it is a folder",
        ErrorKind::NotADirectory => "a part of its path is a file, not a folder",
        ErrorKind::AlreadyExists => "a file of that name is there",
        ErrorKind::StorageFull => "the disk is full",
        ErrorKind::QuotaExceeded => "the user's share of the disk is full",
        ErrorKind::ReadOnlyFilesystem => "its disk can only be read",
        ErrorKind::InvalidFilename => "its name is too long for the disk",
        _ => return Error::new(kind, without_number(&error.to_string())),
    };
    Error::new(kind, words)
}

/// The text of an error of the operating system without its number, as in `Text file busy (os error 26)`.
#[must_use]
pub fn without_number(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, after)) = rest.split_once(" (os error ") {
        out.push_str(before);
        rest = after.split_once(')').map_or("", |(_, rest)| rest);
    }
    out + rest
}

/// Contents of a file; `None` if it exceeds `most` bytes.
///
/// # Errors
/// As [`open`]; memory for it is refused.
pub fn read(path: &Path, most: u64) -> Result<Option<Vec<u8>>> {
    let file = open(path)?;
    let length = file.metadata()?.len();
    read_of(file, length, most)
}

/// Reads the `length` bytes of a file. Memory for all of them is reserved before the first is read,
/// so that a file that does not fit is refused at once.
fn read_of(file: impl Read, length: u64, most: u64) -> Result<Option<Vec<u8>>> {
    if length > most {
        return Ok(None);
    }
    let mut bytes = vec![];
    let room = usize::try_from(length).map_err(|_| too_much(length))?;
    bytes
        .try_reserve_exact(room)
        .map_err(|_| too_much(length))?;
    file.take(most.saturating_add(1))
        .read_to_end(&mut bytes)
        .map_err(in_words)?;
    Ok((bytes.len() as u64 <= most).then_some(bytes))
}

/// The text of a file of at most `most` bytes.
///
/// # Errors
/// As [`read`]; the file is larger, or is not UTF-8.
pub fn read_text(path: &Path, most: u64) -> Result<String> {
    let bytes = read(path, most)?
        .ok_or_else(|| Error::other(format!("more than {most} bytes, the most that are read")))?;
    String::from_utf8(bytes).map_err(|error| {
        let at = error.utf8_error().valid_up_to();
        Error::other(format!("byte {at} is not UTF-8 text"))
    })
}

/// Refuses every kind but a regular file.
///
/// # Errors
/// It is a folder, a pipe, a socket or a device.
pub fn check(kind: FileType) -> Result<()> {
    match name_of(kind) {
        None => Ok(()),
        Some(name) => Err(Error::other(format!("it is {name} and not a regular file"))),
    }
}

/// Name of an irregular kind of file; `None` for a regular one.
#[must_use]
pub fn name_of(kind: FileType) -> Option<&'static str> {
    if kind.is_file() {
        return None;
    }
    if kind.is_dir() {
        return Some("a folder");
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::FileTypeExt as _;
        if kind.is_fifo() {
            return Some("a FIFO");
        }
        if kind.is_socket() {
            return Some("a socket");
        }
        if kind.is_char_device() || kind.is_block_device() {
            return Some("a device");
        }
    }
    Some("something else")
}

fn too_much(length: u64) -> Error {
    Error::new(
        std::io::ErrorKind::OutOfMemory,
        format!("its {length} bytes do not fit in memory"),
    )
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::expect_used)]
    use super::*;

    #[test]
    fn no_more_is_read_than_was_allowed() {
        let path = std::env::temp_dir().join(format!("potamoi-files-{}", std::process::id()));
        std::fs::write(&path, b"abc").unwrap();
        let read_of = |most| (read(&path, most).unwrap(), read_text(&path, most).ok());
        let most = (Some(b"abc".to_vec()), Some("abc".to_owned()));
        assert_eq!(read_of(3), most);
        assert_eq!(read_of(2), (None, None));
        std::fs::write(&path, [b'a', 0xff]).unwrap();
        let error = read_text(&path, 9).unwrap_err().to_string();
        assert_eq!(error, "byte 1 is not UTF-8 text");
        std::fs::remove_file(&path).unwrap();
    }

    /// A reader that nothing may be read from.
    struct Untouched;

    impl Read for Untouched {
        fn read(&mut self, _: &mut [u8]) -> Result<usize> {
            Err(Error::other("it was read"))
        }
    }

    #[test]
    fn what_does_not_fit_in_memory_is_refused_before_it_is_read() {
        // More than any machine has room for, and more than a number of bytes may be.
        for length in [1 << 62, u64::MAX] {
            let error = read_of(Untouched, length, u64::MAX).unwrap_err();
            let said = format!("its {length} bytes do not fit in memory");
            assert_eq!(error.to_string(), said);
            assert_eq!(error.kind(), std::io::ErrorKind::OutOfMemory);
        }
        let error = read_of(Untouched, 3, u64::MAX).unwrap_err().to_string();
        assert_eq!(error, "it was read");
    }

    #[test]
    fn errors_of_the_operating_system_have_no_number() {
        let error = open(Path::new("/no/such/file")).unwrap_err();
        assert_eq!(error.kind(), ErrorKind::NotFound);
        assert_eq!(error.to_string(), "there is no file or folder of that name");
        // Of 133 on, Linux has no errors.
        for number in 1..133 {
            let said = in_words(Error::from_raw_os_error(number)).to_string();
            assert!(!said.is_empty() && !said.contains("os error"), "{said}");
        }
        let own = in_words(Error::other("more than 3 bytes")).to_string();
        assert_eq!(own, "more than 3 bytes");
        let two = "a: b (os error 2); c (os error 13)";
        assert_eq!(without_number(two), "a: b; c");
    }

    #[test]
    fn what_is_no_regular_file_is_refused_by_name() {
        let said = |path: &Path| read(path, 1000).unwrap_err().to_string();
        assert_eq!(
            said(&std::env::temp_dir()),
            "it is a folder and not a regular file"
        );
        #[cfg(unix)]
        {
            let device = "it is a device and not a regular file";
            assert_eq!(said(Path::new("/dev/zero")), device);
            let folder = std::env::temp_dir();
            let pipe = folder.join(format!("potamoi-fifo-{}", std::process::id()));
            let made = std::process::Command::new("mkfifo").arg(&pipe).status();
            assert!(made.unwrap().success());
            // One that is opened waits for ever.
            let (done, told) = std::sync::mpsc::channel();
            let path = pipe.clone();
            std::thread::spawn(move || done.send(read(&path, 1000).map_err(|e| e.to_string())));
            let found = told.recv_timeout(std::time::Duration::from_secs(20));
            std::fs::remove_file(&pipe).unwrap();
            let error = found.expect("the pipe was opened").unwrap_err();
            assert_eq!(error, "it is a FIFO and not a regular file");
        }
    }
}
