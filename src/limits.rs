//! Memory limits of the process: a run that outgrows one ends with words and an exit status.
//!
//! Where memory for something is refused, a Rust program aborts, and a thread that cannot be made
//! panics. Under a limit (`ulimit -v`), the work is therefore done by a child of this program, and
//! what ends the child is said here. The child dies with this process.

use std::process::{Command, ExitCode};

use rustix::process::{
    Pid, Resource, Signal, getpid, getppid, getrlimit, set_parent_process_death_signal,
};

use potamoi_verilated::child::LIMIT;

use crate::failure::Failure;
use crate::stdout;

/// Set in the child, to its parent's number.
const INNER: &str = "POTAMOI_WITHIN_LIMIT";
/// Exit status of a panic.
const PANICKED: i32 = 101;

/// Refuses a time limit of tools that is none.
///
/// # Errors
/// The variable is set, and not to a number of seconds.
pub(crate) fn check_tool_seconds() -> Result<(), Failure> {
    let Some(text) = std::env::var_os(LIMIT) else {
        return Ok(());
    };
    let text = text.to_string_lossy();
    match text.trim().parse::<u64>() {
        Ok(1..) => Ok(()),
        _ => Err(Failure::Usage(format!(
            "{LIMIT} is `{text}`: expected a whole number of seconds, 1 or more; unset it for the \
             limits of each tool"
        ))),
    }
}

/// Runs this command in a child where memory is limited; none where it is not, or in that child.
pub(crate) fn run_within() -> Option<ExitCode> {
    let limit = in_force()?;
    if let Ok(parent) = std::env::var(INNER) {
        // Set by the main thread, which lives as long as its process.
        let _ = set_parent_process_death_signal(Some(Signal::KILL));
        let found = getppid().map(Pid::as_raw_nonzero);
        let is_alive = found.map(|pid| pid.to_string()) == Some(parent);
        if is_alive {
            return None;
        }
        stdout::error(format_args!("{INNER} is not to be set: unset it"));
        return Some(ExitCode::from(2));
    }
    let own = std::env::current_exe().ok()?;
    let mut command = Command::new(own);
    command
        .args(std::env::args_os().skip(1))
        .env(INNER, getpid().as_raw_nonzero().to_string());
    let status = match command.status() {
        Ok(status) => status,
        Err(error) => {
            stdout::error(format_args!(
                "cannot start under the memory limit of {} MiB: {error}; raise it (ulimit -v)",
                limit >> 20
            ));
            return Some(ExitCode::from(2));
        }
    };
    match status.code() {
        Some(code) if code != PANICKED => {
            Some(ExitCode::from(u8::try_from(code).unwrap_or(u8::MAX)))
        }
        _ => {
            stdout::error(format_args!(
                "the limit of {} MiB of memory does not hold what was asked for ({status}): raise it \
                 (ulimit -v), or ask for a smaller picture or model; docs/reference/kept-files.md#memory says what a model \
                 takes",
                limit >> 20
            ));
            Some(ExitCode::from(2))
        }
    }
}

/// Bytes of address space or data that this process may take, where that is limited.
fn in_force() -> Option<u64> {
    let limits = [Resource::As, Resource::Data].map(|what| getrlimit(what).current);
    limits.into_iter().flatten().min()
}
