//! What stands in a ZIP file beside its members.

use std::io::Cursor;

use zip::ZipArchive;

/// The record that ends an archive, without its comment.
const END: &[u8; 4] = b"PK\x05\x06";
const END_LENGTH: usize = 22;

/// Keys of what no member holds: a comment, and bytes behind the archive.
pub fn after_archive(archive: &ZipArchive<Cursor<&[u8]>>, bytes: &[u8]) -> Vec<String> {
    let mut all = vec![];
    let comment = archive.comment().len();
    if comment > 0 {
        all.push("comment of the archive".to_owned());
    }
    let starts = bytes.windows(END.len()).rposition(|own| own == END);
    let end = starts.map_or(0, |at| at + END_LENGTH + comment);
    let left = bytes.len().saturating_sub(end);
    if left > 0 {
        all.push(format!("bytes after the archive ({left})"));
    }
    all
}
