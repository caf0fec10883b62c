//! Memory limits of the process: a run that exceeds one ends with a message and an exit status.
//!
//! Where an allocation is refused, a Rust program aborts, and where a thread cannot be created, it
//! panics. Under a limit (`ulimit -v`) a child of this program therefore does the work, and this
//! process reports the cause of its end. The child dies with this process.

use std::process::{Command, ExitStatus};

use rustix::process::{
    Pid, Resource, Signal, getpid, getppid, getrlimit, set_parent_process_death_signal,
};

use thiserror::Error;

/// Environment variable of the child: its parent's process id.
const INNER: &str = "POTAMOI_WITHIN_LIMIT";
/// Exit status of a panic.
const PANICKED: i32 = 101;

/// Why a run under a memory limit has no result.
#[derive(Debug, Error)]
pub enum MemoryLimitError {
    /// A user set the variable of the child.
    #[error("{INNER} is reserved for this program: unset it")]
    Set,
    /// The child did not start.
    #[error("cannot start under the memory limit of {mib} MiB: {source}; raise it (ulimit -v)")]
    NotStarted {
        /// The limit.
        mib: u64,
        /// The reason.
        source: std::io::Error,
    },
    /// The child ran out of memory.
    #[error(
        "the memory limit of {mib} MiB is too small for this command ({status}): raise it \
         (ulimit -v), or choose a smaller picture or model; docs/reference/kept-files.md#memory \
         lists the memory of models"
    )]
    Exceeded {
        /// The limit.
        mib: u64,
        /// How the child ended.
        status: ExitStatus,
    },
}

/// Runs this program, with the same arguments, in a child where memory is limited, and returns its
/// exit status; `None` where memory is not limited, or in that child.
#[must_use]
pub fn run_within() -> Option<Result<u8, MemoryLimitError>> {
    let limit = in_force()?;
    if let Ok(parent) = std::env::var(INNER) {
        // Set by the main thread, which lives as long as its process.
        let _ = set_parent_process_death_signal(Some(Signal::KILL));
        let found = getppid().map(Pid::as_raw_nonzero);
        let is_alive = found.map(|pid| pid.to_string()) == Some(parent);
        return (!is_alive).then_some(Err(MemoryLimitError::Set));
    }
    let own = std::env::current_exe().ok()?;
    let mut command = Command::new(own);
    command
        .args(std::env::args_os().skip(1))
        .env(INNER, getpid().as_raw_nonzero().to_string());
    let mib = limit >> 20;
    Some(match command.status() {
        Err(source) => Err(MemoryLimitError::NotStarted { mib, source }),
        Ok(status) => match status.code() {
            Some(code) if code != PANICKED => Ok(u8::try_from(code).unwrap_or(u8::MAX)),
            _ => Err(MemoryLimitError::Exceeded { mib, status }),
        },
    })
}

/// Limit of this process's address space or data in bytes, if any.
fn in_force() -> Option<u64> {
    let limits = [Resource::As, Resource::Data].map(|what| getrlimit(what).current);
    limits.into_iter().flatten().min()
}
