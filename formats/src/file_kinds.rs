//! What a file is that was given in place of another.

use std::io::{Error, Read as _};
use std::path::Path;

/// How files of other kinds begin.
const BEGINS: [(&[u8], &str); 13] = [
    (b"ply\n", "a PLY file"),
    (b"ply\r", "a PLY file"),
    (b"\x89PNG", "a PNG picture"),
    (b"\xff\xd8\xff", "a JPEG picture"),
    (b"\x76\x2f\x31\x01", "an OpenEXR picture"),
    (b"PK\x03\x04", "a ZIP archive, as .npz and .sog are"),
    (b"\x1f\x8b", "a gzip file, as .spz is"),
    (b"glTF", "a binary glTF model"),
    (b"\x93NUMPY", "a NumPy array"),
    (b"\x7fELF", "a program"),
    (b"RIFF", "a RIFF file, as WebP pictures are"),
    (b"<svg", "an SVG picture"),
    (b"<!", "an HTML page"),
];
/// The longest of these.
const LONGEST: u64 = 8;

/// What a file is by its first bytes, if it is known; texts are not.
#[must_use]
pub fn kind(bytes: &[u8]) -> Option<&'static str> {
    let found = BEGINS.iter().find(|(begin, _)| bytes.starts_with(begin));
    found.map(|(_, kind)| *kind)
}

/// The error of a file that is longer than `most` bytes, with what it is.
#[must_use]
pub fn too_long(path: &Path, most: u64) -> Error {
    let mut begin = vec![];
    let file = std::fs::File::open(path);
    let read = file.and_then(|file| file.take(LONGEST).read_to_end(&mut begin));
    let known = read.ok().and_then(|_| kind(&begin));
    let told = known.map_or_else(String::new, |kind| format!(": it is {kind}"));
    Error::other(format!(
        "more than {most} bytes, the most that are read{told}"
    ))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn files_are_told_by_how_they_begin() {
        assert_eq!(kind(b"ply\nformat ascii 1.0\n"), Some("a PLY file"));
        assert_eq!(kind(b"\x89PNG\r\n\x1a\n"), Some("a PNG picture"));
        for text in ["", "p", "{\"a\": 1}", "[gu]\nbanks = 4\n", "plywood = 1"] {
            assert_eq!(kind(text.as_bytes()), None, "{text}");
        }
        let longest = BEGINS.iter().map(|(begin, _)| begin.len()).max();
        assert!(longest.unwrap() as u64 <= LONGEST);
    }

    #[test]
    fn a_file_that_is_too_long_is_told_by_its_kind() {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        let said = |name: &str| too_long(&here.join(name), 4).to_string();
        let plain = "more than 4 bytes, the most that are read";
        assert_eq!(said("Cargo.toml"), plain);
        let model = "../golden/tests/fixtures/splats/cloud.compressed.ply";
        assert_eq!(said(model), format!("{plain}: it is a PLY file"));
    }
}
