//! Endings of outputs. A name that ends as another kind of file is refused, since it is a slip
//! that would replace that file. Pictures, plots and pages ask for their ending themselves.

use std::fs;
use std::path::Path;

use crate::failure::Failure;

/// What an output is, and the ending of its name.
fn kind(command: &str, argument: &str) -> Option<(&'static str, &'static str)> {
    Some(match argument {
        "json" | "chrome_trace" | "grid" | "forms" | "memories" => ("JSON", "json"),
        "csv" | "prices" => ("CSV", "csv"),
        "vcd" => ("a VCD waveform", "vcd"),
        "found" => ("a configuration in TOML", "toml"),
        "report" => ("Markdown", "md"),
        "out" if command == "trace" => ("an NPZ archive", "npz"),
        _ => return None,
    })
}

/// Refuses an output with the ending of another kind. Names without an ending, and what is no file,
/// such as `/dev/stdout`, are taken.
///
/// # Errors
/// The name ends otherwise.
pub(super) fn check(command: &str, argument: &str, flag: &str, path: &Path) -> Result<(), Failure> {
    let Some((what, own)) = kind(command, argument) else {
        return Ok(());
    };
    let is_other = path
        .extension()
        .is_some_and(|found| !found.eq_ignore_ascii_case(own));
    let is_file = fs::metadata(path).map_or(true, |found| found.is_file());
    if is_other && is_file {
        return Err(Failure::Usage(format!(
            "{flag} {} would be {what}: name a file that ends in .{own}",
            path.display()
        )));
    }
    Ok(())
}
