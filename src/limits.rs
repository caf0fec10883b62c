//! Memory limits of the process: a run that exceeds one ends with a message and an exit status.
//!
//! Where an allocation is refused, a Rust program aborts, and where a thread cannot be created, it
//! panics. Under a limit (`ulimit -v`) a child of this program therefore does the work, and this
//! process reports the cause of its end. The child dies with this process.

use std::process::{Command, ExitCode};

use rustix::process::{
    Pid, Resource, Signal, getpid, getppid, getrlimit, set_parent_process_death_signal,
};

use potamoi_verilated::child::LIMIT;

use crate::failure::Failure;
use crate::stdout;

/// Environment variable of the child: its parent's process id.
const INNER: &str = "POTAMOI_WITHIN_LIMIT";
/// Exit status of a panic.
const PANICKED: i32 = 101;

/// Refuses an invalid time limit of tools.
///
/// # Errors
/// The variable is set to something else than a number of seconds.
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

/// Runs this command in a child where memory is limited; `None` where it is not, or in that child.
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

/// Limit of this process's address space or data in bytes, if any.
fn in_force() -> Option<u64> {
    let limits = [Resource::As, Resource::Data].map(|what| getrlimit(what).current);
    limits.into_iter().flatten().min()
}
