//! What a command says.

use std::fmt::Arguments;
use std::io::Write as _;

/// Prints a line. Whoever reads may stop doing so (`| head`): work goes on, and
/// reports are still written.
macro_rules! say {
    ($($arg:tt)*) => {
        $crate::say::line(format_args!($($arg)*))
    };
}

pub(crate) use say;

pub(crate) fn line(text: Arguments<'_>) {
    // Nobody is left to be told.
    let _ = writeln!(std::io::stdout().lock(), "{text}");
}
