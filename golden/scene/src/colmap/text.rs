//! A text file of a reconstruction, line by line, and the fields of a line.

use std::fmt::Display;
use std::fs::File;
use std::io::{BufRead as _, BufReader};
use std::path::PathBuf;
use std::str::FromStr;

use super::error::{ColmapError, Wrong};

/// The longest line in bytes: a line of `images.txt` holds every point of an image.
pub(super) const MAX_LINE: u64 = 1 << 26;
/// Maximum length of a wrong value in messages, in characters.
const TOLD: usize = 60;
/// Maximum number of cameras and of images.
pub(super) const MAX_ENTRIES: usize = 1 << 20;

/// A file, read line by line.
pub(super) struct Text {
    path: PathBuf,
    file: BufReader<File>,
    /// The current line and its number, from 1.
    bytes: Vec<u8>,
    pub(super) number: usize,
}

impl Text {
    pub(super) fn open(path: PathBuf) -> Result<Self, ColmapError> {
        match potamoi_base::files::open(&path) {
            Ok(file) => Ok(Self {
                path,
                file: BufReader::new(file),
                bytes: vec![],
                number: 0,
            }),
            Err(source) if path.with_extension("bin").exists() => Err(ColmapError::Read {
                source: std::io::Error::other(format!(
                    "{source}; the binary form beside it is not read"
                )),
                path,
            }),
            Err(source) => Err(ColmapError::Read { path, source }),
        }
    }

    pub(super) fn wrong(&self, found: String, expected: &str) -> ColmapError {
        ColmapError::File {
            path: self.path.clone(),
            found,
            expected: expected.to_owned(),
        }
    }

    /// An error in the current line.
    pub(super) fn at(&self, (field, value, expected): Wrong) -> ColmapError {
        ColmapError::Line {
            path: self.path.clone(),
            line: self.number,
            field,
            value,
            expected,
        }
    }

    /// Reads the next line; `false` at the end.
    pub(super) fn advance(&mut self) -> Result<bool, ColmapError> {
        self.bytes.clear();
        self.number += 1;
        let read = self.read_line().map_err(|source| ColmapError::Read {
            path: self.path.clone(),
            source,
        })?;
        if self.bytes.len() as u64 > MAX_LINE {
            let expected = format!("at most {MAX_LINE} bytes a line");
            return Err(self.at(("text", "longer".to_owned(), expected)));
        }
        // The mark that some editors put before UTF-8.
        if self.number == 1 && self.bytes.starts_with(b"\xef\xbb\xbf") {
            self.bytes.drain(..3);
        }
        Ok(read)
    }

    /// Reads up to a line feed, a carriage return, or both; `false` at the end. Lines that are too
    /// long are cut off.
    fn read_line(&mut self) -> std::io::Result<bool> {
        let mut any = false;
        while self.bytes.len() as u64 <= MAX_LINE {
            let there = self.file.fill_buf()?;
            if there.is_empty() {
                break;
            }
            any = true;
            let end = there.iter().position(|byte| matches!(byte, b'\n' | b'\r'));
            let Some(at) = end else {
                let all = there.len();
                self.bytes.extend_from_slice(there);
                self.file.consume(all);
                continue;
            };
            let returned = there[at] == b'\r';
            self.bytes.extend_from_slice(&there[..at]);
            self.file.consume(at + 1);
            if returned && self.file.fill_buf()?.first() == Some(&b'\n') {
                self.file.consume(1);
            }
            break;
        }
        Ok(any)
    }

    /// The current line.
    pub(super) fn line(&self) -> &[u8] {
        self.bytes.trim_ascii()
    }

    /// Reads up to a line that is neither empty nor a comment; `false` if there is none.
    pub(super) fn advance_to_text(&mut self) -> Result<bool, ColmapError> {
        while self.advance()? {
            if !self.line().is_empty() && !self.line().starts_with(b"#") {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

/// The fields of a line, one after another.
pub(super) struct Fields<'a>(pub(super) &'a str);

impl<'a> Fields<'a> {
    pub(super) fn of(line: &'a [u8]) -> Result<Self, Wrong> {
        let text = std::str::from_utf8(line);
        let text = text.map_err(|e| {
            let at = e.valid_up_to() + 1;
            (
                "text",
                format!("not UTF-8 at byte {at}"),
                "UTF-8: save it so".to_owned(),
            )
        })?;
        Ok(Self(text))
    }

    /// The next field; empty at the end.
    pub(super) fn next(&mut self) -> &'a str {
        let (field, rest) = self
            .0
            .split_once(|c: char| c.is_ascii_whitespace())
            .unwrap_or((self.0, ""));
        self.0 = rest.trim_start();
        field
    }

    pub(super) fn parse<T: FromStr>(
        &mut self,
        field: &'static str,
        expected: &str,
    ) -> Result<T, Wrong> {
        let text = self.next();
        let wrong = |_| (field, shown(text), expected.to_owned());
        text.parse().map_err(wrong)
    }

    pub(super) fn number<R>(
        &mut self,
        field: &'static str,
        range: R,
        expected: &str,
    ) -> Result<f64, Wrong>
    where
        R: std::ops::RangeBounds<f64>,
    {
        let value: f64 = self.parse(field, expected)?;
        // Not a number is in no range.
        if range.contains(&value) {
            Ok(value)
        } else {
            Err((field, shown(value), expected.to_owned()))
        }
    }

    pub(super) fn id(&mut self, field: &'static str) -> Result<u32, Wrong> {
        let expected = "a whole number from 0 to 4294967295";
        let ids = 0.0..=f64::from(u32::MAX);
        self.whole(field, ids, expected).map(|id| id as u32)
    }

    /// A whole number in any notation.
    pub(super) fn whole<R>(
        &mut self,
        field: &'static str,
        range: R,
        expected: &str,
    ) -> Result<f64, Wrong>
    where
        R: std::ops::RangeBounds<f64>,
    {
        let value = self.number(field, range, expected)?;
        match value.fract() == 0.0 {
            true => Ok(value),
            false => Err((field, shown(value), expected.to_owned())),
        }
    }
}

pub(super) fn shown(value: impl Display) -> String {
    match value.to_string() {
        text if text.is_empty() => "missing".to_owned(),
        text => text.chars().take(TOLD).collect(),
    }
}
