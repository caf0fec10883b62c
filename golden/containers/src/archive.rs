//! Contents of a ZIP file that readers of members do not see.
//!
//! A reader sees only one of two members of the same name, and neither the bytes before and behind
//! the archive nor its comment. The directory is walked here once more, for all file formats that
//! are ZIP archives.

use std::collections::HashSet;
use std::io::{Read, Seek, SeekFrom};

use zip::ZipArchive;

/// An entry of the directory, followed by a name, an extra field and a comment.
const ENTRY: (&[u8; 4], usize) = (b"PK\x01\x02", 46);
/// The end record of large archives, whose length excludes itself.
const END_64: (&[u8; 4], usize) = (b"PK\x06\x06", 12);
/// The locator of that record.
const LOCATOR: (&[u8; 4], usize) = (b"PK\x06\x07", 20);
/// The end record of an archive, followed by a comment.
const END: (&[u8; 4], usize) = (b"PK\x05\x06", 22);

/// Contents that no reader of members sees.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Beside {
    /// A member that occurs twice, so that it is ambiguous.
    pub twice: Option<String>,
    /// Keys of a comment, and of bytes before and behind the archive.
    pub keys: Vec<String>,
}

/// Examines a file whose members are open in `archive`.
///
/// # Errors
/// The file cannot be read to the end of its directory.
pub fn beside<R: Read + Seek>(
    archive: &ZipArchive<R>,
    mut file: impl Read + Seek,
) -> std::io::Result<Beside> {
    let mut found = Beside::default();
    if archive.offset() > 0 {
        let key = format!("bytes before the archive ({})", archive.offset());
        found.keys.push(key);
    }
    if !archive.comment().is_empty() {
        found.keys.push("comment of the archive".to_owned());
    }
    let length = file.seek(SeekFrom::End(0))?;
    let mut at = archive.central_directory_start();
    let mut names = HashSet::new();
    loop {
        file.seek(SeekFrom::Start(at))?;
        let mut head = [0; END_64.1];
        file.read_exact(&mut head)?;
        let is = |kind: (&[u8; 4], usize)| head.starts_with(kind.0);
        let mut rest = [0; ENTRY.1 - END_64.1];
        let two = |from: usize, rest: &[u8]| {
            usize::from(u16::from_le_bytes([rest[from], rest[from + 1]]))
        };
        if is(ENTRY) {
            file.read_exact(&mut rest)?;
            let lengths = [28, 30, 32].map(|from| two(from - END_64.1, &rest));
            let mut name = vec![0; lengths[0]];
            file.read_exact(&mut name)?;
            at += (ENTRY.1 + lengths.into_iter().sum::<usize>()) as u64;
            let name = String::from_utf8_lossy(&name).into_owned();
            if !names.insert(name.clone()) {
                found.twice.get_or_insert(name);
            }
        } else if is(END_64) {
            let [.., a, b, c, d, e, f, g, h] = head;
            let more = u64::from_le_bytes([a, b, c, d, e, f, g, h]);
            at = at.saturating_add(more).saturating_add(END_64.1 as u64);
        } else if is(LOCATOR) {
            at += LOCATOR.1 as u64;
        } else if is(END) {
            file.read_exact(&mut rest[..END.1 - END_64.1])?;
            at += (END.1 + two(20 - END_64.1, &rest)) as u64;
            break;
        } else {
            break;
        }
    }
    let left = length.saturating_sub(at);
    if left > 0 {
        found.keys.push(format!("bytes after the archive ({left})"));
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::io::{Cursor, Write as _};

    use zip::write::{SimpleFileOptions, ZipWriter};

    use super::*;

    fn archive(names: [&str; 2], comment: &str) -> Vec<u8> {
        let mut zip = ZipWriter::new(Cursor::new(vec![]));
        for name in names {
            let options = SimpleFileOptions::default().large_file(true);
            zip.start_file(name, options).unwrap();
            zip.write_all(b"PK\x05\x06 numbers").unwrap();
        }
        zip.set_comment(comment);
        zip.finish().unwrap().into_inner()
    }

    fn found(bytes: &[u8]) -> Beside {
        let archive = ZipArchive::new(Cursor::new(bytes)).unwrap();
        beside(&archive, Cursor::new(bytes)).unwrap()
    }

    #[test]
    fn what_stands_beside_the_members_is_found() {
        let plain = archive(["aa", "ab"], "");
        assert_eq!(found(&plain), Beside::default());
        let said = archive(["aa", "ab"], "made by hand");
        assert_eq!(found(&said).keys, ["comment of the archive"]);
        let tail = [&plain[..], b"tail"].concat();
        assert_eq!(found(&tail).keys, ["bytes after the archive (4)"]);
        let both = [b"before", &said[..], b"tail"].concat();
        let expected = [
            "bytes before the archive (6)",
            "comment of the archive",
            "bytes after the archive (4)",
        ];
        assert_eq!(found(&both).keys, expected);
    }

    /// A writer refuses a second member of a name, so that it is renamed in the bytes.
    #[test]
    fn a_member_that_is_given_twice_is_found() {
        let mut bytes = archive(["aa", "ab"], "");
        for at in 0..bytes.len() - 1 {
            if &bytes[at..at + 2] == b"ab" {
                bytes[at + 1] = b'a';
            }
        }
        assert_eq!(found(&bytes).twice.as_deref(), Some("aa"));
    }
}
