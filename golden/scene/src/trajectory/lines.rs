//! Lines of a text file, and the numbers of a line.

use std::path::Path;

use super::error::{TrajectoryError, Wrong};

/// Maximum length of a wrong value in messages, in characters.
const TOLD: usize = 60;

/// The bytes of a file without the mark that some editors put before UTF-8.
pub(super) struct Lines<'a> {
    pub(super) path: &'a Path,
    bytes: &'a [u8],
}

/// A line without the blanks around it, with its number from 1.
#[derive(Clone, Copy)]
pub(super) struct Line<'a> {
    pub(super) number: usize,
    bytes: &'a [u8],
}

impl<'a> Lines<'a> {
    pub(super) fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        Self { path, bytes }
    }

    /// All lines that are not empty, comments included. A line ends with a line feed, a carriage
    /// return, or both.
    pub(super) fn all(&self) -> impl Iterator<Item = Line<'a>> + use<'a> {
        let mut rest = self.bytes;
        let mut number = 0;
        let lines = std::iter::from_fn(move || {
            if rest.is_empty() {
                return None;
            }
            let end = rest.iter().position(|b| matches!(b, b'\n' | b'\r'));
            let (line, behind) = rest.split_at(end.unwrap_or(rest.len()));
            let mark = match behind {
                [b'\r', b'\n', ..] => 2,
                [] => 0,
                _ => 1,
            };
            rest = &behind[mark..];
            number += 1;
            Some(Line {
                number,
                bytes: line.trim_ascii(),
            })
        });
        lines.filter(|line| !line.bytes.is_empty())
    }

    /// Lines of numbers: all but comments.
    pub(super) fn data(&self) -> impl Iterator<Item = Line<'a>> + use<'a> {
        self.all().filter(|line| !line.is_comment())
    }

    pub(super) fn at(&self, line: Line<'_>, wrong: Wrong) -> TrajectoryError {
        line.wrong(self.path, wrong)
    }
}

impl<'a> Line<'a> {
    pub(super) fn is_comment(self) -> bool {
        self.bytes.starts_with(b"#")
    }

    pub(super) fn wrong(self, path: &Path, (field, value, expected): Wrong) -> TrajectoryError {
        TrajectoryError::Line {
            path: path.to_owned(),
            line: self.number,
            field,
            value,
            expected,
        }
    }

    pub(super) fn text(self) -> Result<&'a str, Wrong> {
        std::str::from_utf8(self.bytes).map_err(|e| {
            let at = e.valid_up_to() + 1;
            let found = format!("not UTF-8 at byte {at}");
            ("text", found, "UTF-8: save it so".to_owned())
        })
    }

    /// The words between blanks and commas.
    pub(super) fn words(self) -> Result<Vec<&'a str>, Wrong> {
        let mark = |c: char| c == ',' || c.is_ascii_whitespace();
        let words = self.text()?.split(mark).filter(|word| !word.is_empty());
        Ok(words.collect())
    }
}

/// A number within -`most` to `most`.
pub(super) fn number(field: &'static str, text: &str, most: f64) -> Result<f64, Wrong> {
    let value: Option<f64> = text.parse().ok();
    // Not a number is in no range.
    match value.filter(|value| value.abs() <= most) {
        Some(value) => Ok(value),
        None => {
            let expected = format!("a number from -{most:e} to {most:e}");
            Err((field, shown(text), expected))
        }
    }
}

pub(super) fn shown(text: &str) -> String {
    match text {
        "" => "missing".to_owned(),
        text => text.chars().take(TOLD).collect(),
    }
}
