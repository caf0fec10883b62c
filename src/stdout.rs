//! Output of a command.

use std::fmt::Arguments;
use std::io::{Error, ErrorKind, Write as _};
use std::sync::{Mutex, PoisonError};

use potamoi_base::files::without_number;

/// Prints a line. A reader may close the pipe (`| head`): the command continues, and reports are
/// still written.
macro_rules! say {
    ($($arg:tt)*) => {
        $crate::stdout::line(format_args!($($arg)*))
    };
}

/// Prints a text broken at words, within a hundred characters: the indentation of its first line in
/// characters, then the text; other lines are indented by two more.
macro_rules! prose {
    ($indent:literal, $($arg:tt)*) => {
        $crate::stdout::broken($indent, &format!($($arg)*))
    };
}

pub(crate) use {prose, say};

/// Prints a text as [`prose!`].
pub(crate) fn broken(indent: usize, text: &str) {
    let [first, rest] = [indent, indent + 2].map(|count| " ".repeat(count));
    say!("{}", crate::tables::broken_at_words(text, &first, &rest));
}

/// Error of the first failed write, except for a closed pipe.
static LOST: Mutex<Option<String>> = Mutex::new(None);

pub(crate) fn line(text: Arguments<'_>) {
    note(writeln!(std::io::stdout().lock(), "{text}"));
}

/// Prints an error on standard error, which may be closed.
pub(crate) fn error(text: Arguments<'_>) {
    // Nobody is left to be told.
    let _ = writeln!(
        std::io::stderr().lock(),
        "error: {}",
        harmless(&shortened(&without_number(&text.to_string())))
    );
}

/// A text whose control characters, which a damaged file may bring, are written as escapes; lines
/// stay lines.
fn harmless(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for own in text.chars() {
        match own.is_control() && own != '\n' {
            true => out.extend(own.escape_default()),
            false => out.push(own),
        }
    }
    out
}

/// Prints a remark on standard error, which may be closed.
pub(crate) fn remark(text: Arguments<'_>) {
    let _ = writeln!(std::io::stderr().lock(), "note: {text}");
}

/// Prints a line of progress on standard error, which may be closed.
pub(crate) fn progress(text: Arguments<'_>) {
    let _ = writeln!(std::io::stderr().lock(), "progress: {text}");
}

/// Lengths of the start and the end of a long error that are printed, in characters.
const TOLD: [usize; 2] = [6000, 1000];

/// An error without its middle where it quotes too much of a damaged file: it begins with file and
/// field, and ends with the remedy.
fn shortened(text: &str) -> String {
    let count = text.chars().count();
    let [head, tail] = TOLD;
    let Some(left_out) = count.checked_sub(head + tail).filter(|n| *n > 0) else {
        return text.to_owned();
    };
    let start: String = text.chars().take(head).collect();
    let end: String = text.chars().skip(head + left_out).collect();
    format!("{start} [{left_out} characters left out] {end}")
}

/// The output that was lost, and why.
pub(crate) fn lost() -> Option<String> {
    note(std::io::stdout().lock().flush());
    LOST.lock().unwrap_or_else(PoisonError::into_inner).take()
}

fn note(written: Result<(), Error>) {
    if let Err(error) = written
        && error.kind() != ErrorKind::BrokenPipe
    {
        let mut lost = LOST.lock().unwrap_or_else(PoisonError::into_inner);
        lost.get_or_insert_with(|| error.to_string());
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn control_characters_of_a_file_are_escaped() {
        assert_eq!(harmless("a\u{1b}[31mb\0c\nd"), "a\\u{1b}[31mb\\u{0}c\nd");
    }

    #[test]
    fn long_errors_keep_their_start_and_their_end() {
        let [head, tail] = TOLD;
        let whole = "x".repeat(head + tail);
        assert_eq!(shortened(&whole), whole);
        let long = format!("{}yyy{}", "\u{e9}".repeat(head), "z".repeat(tail));
        let expected = format!(
            "{} [3 characters left out] {}",
            "\u{e9}".repeat(head),
            "z".repeat(tail)
        );
        assert_eq!(shortened(&long), expected);
    }
}
