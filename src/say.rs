//! What a command says.

use std::fmt::Arguments;
use std::io::{Error, ErrorKind, Write as _};
use std::sync::{Mutex, PoisonError};

/// Prints a line. Whoever reads may stop doing so (`| head`): work goes on, and
/// reports are still written.
macro_rules! say {
    ($($arg:tt)*) => {
        $crate::say::line(format_args!($($arg)*))
    };
}

pub(crate) use say;

/// Why the first of what was said could not be written, but for a reader that went away.
static LOST: Mutex<Option<String>> = Mutex::new(None);

pub(crate) fn line(text: Arguments<'_>) {
    note(writeln!(std::io::stdout().lock(), "{text}"));
}

/// Says of an error, on standard error, which may be closed.
pub(crate) fn error(text: Arguments<'_>) {
    // Nobody is left to be told.
    let _ = writeln!(std::io::stderr().lock(), "error: {text}");
}

/// What of all that was said was not written, and why.
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
