//! Child processes with a time limit, which never outlive this process.
//!
//! A program runs in a process group of its own, under a shell that also starts a guard in that
//! group. The guard reads from a pipe whose other end this process holds, and kills the whole group
//! when the pipe closes: when the program ends, when its time is over, or when this process dies in
//! any way. Neither the thread that started the program nor the program's own children matter. (A
//! signal on the parent's death, `PR_SET_PDEATHSIG`, follows the thread and reaches the first child
//! only.)

use std::ffi::OsStr;
use std::fs;
use std::io::{BufRead as _, BufReader, PipeWriter, Read, Write as _};
use std::os::unix::fs::PermissionsExt as _;
use std::os::unix::process::{CommandExt as _, ExitStatusExt as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdin, ChildStdout, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::sync::{Arc, Mutex, PoisonError, Weak};
use std::time::{Duration, Instant};

const SHELL: &str = "/bin/sh";
/// The guard's pipe is standard input; the program gets an empty one.
const GUARDED: &str = "exec 3<&0; { while read -r _ <&3; do :; done; kill -KILL 0; } \
     </dev/null >/dev/null 2>&1 & exec \"$@\" </dev/null 3<&-";
/// The guard's pipe is standard error, since the program reads from standard input.
const GUARDED_READER: &str = "exec 3<&2 2>/dev/null; { while read -r _ <&3; do :; done; \
     kill -KILL 0; } </dev/null >/dev/null & exec \"$@\" 3<&-";

/// Environment variable that overrides every time limit, in seconds.
pub const LIMIT: &str = "POTAMOI_TOOL_SECONDS";
/// Time limit for a program to report its version.
pub const TO_ANSWER: Duration = Duration::from_secs(30);
/// Time limit to read this project's Verilog or to model a memory: many times the longest run.
pub const TO_READ: Duration = Duration::from_secs(100);
/// Time limit to compile, synthesise or place a unit.
pub const TO_BUILD: Duration = Duration::from_secs(3600);

/// Bytes kept of each output: at its beginning, and at its end.
const FIRST: usize = 32 << 20;
const LAST: usize = 64 << 10;
/// Wait for outputs held open by a process that left the group.
const LINGER: Duration = Duration::from_secs(2);

/// Result of a program that ended.
#[derive(Debug)]
pub struct Done {
    /// Exit status, never a signal.
    pub status: ExitStatus,
    /// Standard output: its first 32 MiB, and the end of what came after.
    pub out: Vec<u8>,
    /// Standard error, bounded in the same way.
    pub err: Vec<u8>,
}

/// Why a program gave no result, independent of its input.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// There is no such program.
    #[error("{program} is not installed")]
    Missing {
        /// Its name.
        program: String,
    },
    /// The system refused to start it.
    #[error("the run does not start: {reason}")]
    Start {
        /// The reason.
        reason: String,
    },
    /// It exceeded its time limit.
    #[error("the run gave no result within {seconds} s and was ended; {LIMIT}=SECONDS allows more")]
    Late {
        /// The limit.
        seconds: u64,
    },
    /// It ended early.
    #[error("the run ended before it answered: {reason}")]
    Ended {
        /// The evidence.
        reason: String,
    },
    /// It succeeded without doing what was asked.
    #[error("it succeeds but {what}")]
    Nothing {
        /// The missing file or answer.
        what: String,
    },
    /// A signal ended it.
    #[error("signal {signal} ended it")]
    Killed {
        /// Its number.
        signal: i32,
    },
}

/// Runs a program to its end, without input.
///
/// # Errors
/// It is missing, does not start, ends by a signal, or exceeds `limit`.
pub fn run(command: &Command, limit: Duration) -> Result<Done, Fault> {
    find(command)?;
    let mut guarded = guarded(command, GUARDED);
    guarded
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut child = guarded.spawn().map_err(|e| start(&e))?;
    let guard = child.stdin.take();
    let outputs = [
        child.stdout.take().map(collect),
        child.stderr.take().map(collect),
    ];
    let status = wait(&mut child, guard, limit)?;
    let [out, err] = outputs.map(|output| {
        let output = output.and_then(|o| o.recv_timeout(LINGER).ok());
        output.unwrap_or_default()
    });
    Ok(Done { status, out, err })
}

/// Runs a program to its end and returns its output as text; [`None`] where it failed.
///
/// # Errors
/// As [`run`].
pub fn says(command: &Command, limit: Duration) -> Result<Option<String>, Fault> {
    let done = run(command, limit)?;
    let text = [done.out, done.err].concat();
    let text = String::from_utf8_lossy(&text).into_owned();
    Ok(done.status.success().then_some(text))
}

/// An interactive program: one line in, one line out.
#[derive(Debug)]
pub struct Talker {
    child: Child,
    from: BufReader<ChildStdout>,
    state: Arc<Talk>,
}

#[derive(Debug)]
struct Talk {
    /// Kills the program's group when dropped.
    guard: Mutex<Option<PipeWriter>>,
    begin: Instant,
    limit: Duration,
    /// Time of the open question in milliseconds since the start, plus 1; 0 without one.
    asked: AtomicU64,
    is_late: AtomicBool,
}

/// Starts a program that answers each line by a line within `limit`.
///
/// # Errors
/// It is missing or does not start.
pub fn talk(command: &Command, limit: Duration) -> Result<Talker, Fault> {
    find(command)?;
    let (theirs, guard) = std::io::pipe().map_err(|e| start(&e))?;
    let mut guarded = guarded(command, GUARDED_READER);
    guarded
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::from(theirs));
    let mut child = guarded.spawn().map_err(|e| start(&e))?;
    let from = child.stdout.take().ok_or_else(|| Fault::Start {
        reason: "it has no standard output".into(),
    })?;
    let state = Arc::new(Talk {
        guard: Mutex::new(Some(guard)),
        begin: Instant::now(),
        limit: in_force(limit),
        asked: AtomicU64::new(0),
        is_late: AtomicBool::new(false),
    });
    watch(Arc::downgrade(&state));
    Ok(Talker {
        child,
        from: BufReader::new(from),
        state,
    })
}

/// Kills a program that is late with an answer, so that a waiting reader sees the end of its
/// output.
fn watch(talk: Weak<Talk>) {
    std::thread::spawn(move || {
        while let Some(talk) = talk.upgrade() {
            let asked = talk.asked.load(Ordering::Relaxed);
            let asked_at = Duration::from_millis(asked.saturating_sub(1));
            if asked > 0 && talk.begin.elapsed() > asked_at + talk.limit {
                talk.is_late.store(true, Ordering::Relaxed);
                talk.end();
            }
            drop(talk);
            std::thread::sleep(Duration::from_millis(100));
        }
    });
}

impl Talk {
    fn end(&self) {
        *self.guard.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

impl Talker {
    /// Writes a line and reads one, without its newline.
    ///
    /// # Errors
    /// The program is late, or has ended.
    pub fn ask(&mut self, line: &str, answer: &mut String) -> Result<(), Fault> {
        let talk = &self.state;
        let now = u64::try_from(talk.begin.elapsed().as_millis()).unwrap_or(u64::MAX);
        talk.asked.store(now.saturating_add(1), Ordering::Relaxed);
        answer.clear();
        let written = match &mut self.child.stdin {
            Some(to) => to.write_all(line.as_bytes()).and_then(|()| to.flush()),
            None => Err(std::io::ErrorKind::BrokenPipe.into()),
        };
        let read = written.and_then(|()| self.from.read_line(answer));
        talk.asked.store(0, Ordering::Relaxed);
        if talk.is_late.load(Ordering::Relaxed) {
            return Err(Fault::Late {
                seconds: talk.limit.as_secs(),
            });
        }
        match read {
            Ok(1..) => Ok(()),
            Ok(0) => Err(Fault::Ended {
                reason: "it closed its output".into(),
            }),
            Err(e) => Err(Fault::Ended {
                reason: e.to_string(),
            }),
        }
    }
}

impl Drop for Talker {
    fn drop(&mut self) {
        self.child.stdin = None;
        self.state.end();
        // One that has ended already is as good.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn start(error: &std::io::Error) -> Fault {
    Fault::Start {
        reason: error.to_string(),
    }
}

/// Checks that the program exists; the shell would report it in its own words.
fn find(command: &Command) -> Result<(), Fault> {
    let path = std::env::var_os("PATH").unwrap_or_default();
    let name = command.get_program();
    which(name, &path).map(drop).ok_or_else(|| Fault::Missing {
        program: name.to_string_lossy().into_owned(),
    })
}

/// Path of a program: the name itself if it is a path, or the first executable of that name in the
/// folders of `path`.
#[must_use]
pub fn which(name: &OsStr, path: &OsStr) -> Option<PathBuf> {
    let can_run = |path: &PathBuf| {
        fs::metadata(path).is_ok_and(|m| m.is_file() && m.permissions().mode() & 0o111 != 0)
    };
    if Path::new(name).components().count() > 1 {
        return Some(PathBuf::from(name)).filter(can_run);
    }
    let mut places = std::env::split_paths(path).map(|folder| folder.join(name));
    places.find(can_run)
}

/// Shell command that runs a program with its guard.
fn guarded(command: &Command, script: &str) -> Command {
    let mut shell = Command::new(SHELL);
    shell.args(["-c", script, "sh"]);
    shell.arg(command.get_program()).args(command.get_args());
    for (name, value) in command.get_envs() {
        match value {
            Some(value) => shell.env(name, value),
            None => shell.env_remove(name),
        };
    }
    if let Some(folder) = command.get_current_dir() {
        shell.current_dir(folder);
    }
    shell.process_group(0);
    shell
}

/// An invalid time limit in the environment.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error(
    "{LIMIT} is `{0}`: expected a whole number of seconds, 1 or more; unset it for the limits of \
     each tool"
)]
pub struct BadLimit(String);

/// Checks the override of the time limits by the environment, if there is one.
///
/// # Errors
/// The variable is set to something else than a number of seconds.
pub fn check_limit() -> Result<(), BadLimit> {
    let Some(text) = std::env::var_os(LIMIT) else {
        return Ok(());
    };
    let text = text.to_string_lossy();
    match text.trim().parse::<u64>() {
        Ok(1..) => Ok(()),
        _ => Err(BadLimit(text.into_owned())),
    }
}

/// The time limit, or its override by the environment.
fn in_force(limit: Duration) -> Duration {
    let set = std::env::var(LIMIT).ok();
    set.and_then(|text| text.trim().parse().ok())
        .map_or(limit, Duration::from_secs)
}

/// Waits for the end of a child, or of its time limit.
fn wait(
    child: &mut Child,
    guard: Option<ChildStdin>,
    limit: Duration,
) -> Result<ExitStatus, Fault> {
    let limit = in_force(limit);
    let begin = Instant::now();
    let mut pause = Duration::from_micros(500);
    let status = loop {
        match child.try_wait() {
            Ok(Some(status)) => break Ok(status),
            Ok(None) if begin.elapsed() < limit => {}
            Ok(None) => {
                break Err(Fault::Late {
                    seconds: limit.as_secs(),
                });
            }
            Err(e) => break Err(start(&e)),
        }
        std::thread::sleep(pause);
        pause = (2 * pause).min(Duration::from_millis(10));
    };
    // The guard ends what is left of the group.
    drop(guard);
    let status = status.inspect_err(|_| {
        let _ = child.kill();
        let _ = child.wait();
    })?;
    match status.signal() {
        Some(signal) => Err(Fault::Killed { signal }),
        None => Ok(status),
    }
}

/// Reads an output to its end, and keeps a bounded part.
fn collect(mut from: impl Read + Send + 'static) -> Receiver<Vec<u8>> {
    let (to, output) = channel();
    std::thread::spawn(move || {
        let mut first = vec![];
        let mut last = vec![];
        let mut bytes = vec![0; 1 << 16];
        while let Ok(read @ 1..) = from.read(&mut bytes) {
            let (head, tail) = bytes[..read].split_at(read.min(FIRST - first.len()));
            first.extend_from_slice(head);
            last.extend_from_slice(tail);
            if last.len() > 2 * LAST {
                last.drain(..last.len() - LAST);
            }
        }
        first.append(&mut last);
        // Nobody may wait for it any more.
        let _ = to.send(first);
    });
    output
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn shell(script: &str) -> Command {
        let mut command = Command::new(SHELL);
        command.args(["-c", script]);
        command
    }

    /// Processes whose command line contains a text.
    fn alive(mark: &str) -> usize {
        let entries = fs::read_dir("/proc").unwrap().flatten();
        let lines = entries.filter_map(|e| fs::read(e.path().join("cmdline")).ok());
        lines
            .filter(|line| String::from_utf8_lossy(line).contains(mark))
            .count()
    }

    fn ends(mark: &str) -> bool {
        let begin = Instant::now();
        while begin.elapsed() < Duration::from_secs(2) {
            if alive(mark) == 0 {
                return true;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        false
    }

    #[test]
    fn outputs_and_status_come_back() {
        let done = run(&shell("echo out; echo err >&2; exit 3"), TO_ANSWER).unwrap();
        assert_eq!((done.out, done.err), (b"out\n".to_vec(), b"err\n".to_vec()));
        assert_eq!(done.status.code(), Some(3));
        let input = run(&shell("cat; pwd"), TO_ANSWER).unwrap();
        assert!(input.status.success(), "standard input is empty");
    }

    #[test]
    fn faults_are_told_apart() {
        let missing = run(&Command::new("no-such-program"), TO_ANSWER).unwrap_err();
        assert_eq!(missing.to_string(), "no-such-program is not installed");
        let killed = run(&shell("kill -9 $$"), TO_ANSWER).unwrap_err();
        assert_eq!(killed, Fault::Killed { signal: 9 });
        let begin = Instant::now();
        let late = run(
            &shell("sleep 300.125 & sleep 300.125"),
            Duration::from_secs(1),
        );
        assert_eq!(late.unwrap_err(), Fault::Late { seconds: 1 });
        assert!(begin.elapsed() < Duration::from_secs(5));
        assert!(ends("300.125"), "its children end with it");
    }

    #[test]
    fn what_a_program_leaves_running_ends_with_it() {
        let done = run(&shell("sleep 300.25 & echo out"), TO_ANSWER).unwrap();
        assert_eq!(done.out, b"out\n");
        assert!(ends("300.25"));
    }

    #[test]
    fn outputs_are_bounded() {
        let script = "yes 1234567 | head -c 90000000; echo end";
        let done = run(&shell(script), TO_READ).unwrap();
        assert!(done.out.len() <= FIRST + 2 * LAST);
        assert!(done.out.starts_with(b"1234567\n") && done.out.ends_with(b"end\n"));
    }

    #[test]
    fn a_talker_ends_when_it_is_dropped() {
        let script = "read -r x; echo got $x; sleep 300.375 & sleep 300.375";
        let mut talker = talk(&shell(script), TO_READ).unwrap();
        let mut line = String::new();
        talker.ask("a\n", &mut line).unwrap();
        assert_eq!(line, "got a\n");
        drop(talker);
        assert!(ends("300.375"));
    }

    #[test]
    fn a_talker_that_is_late_or_gone_is_named() {
        let mut line = String::new();
        let mut late = talk(&shell("sleep 300.5"), Duration::from_secs(1)).unwrap();
        let fault = late.ask("a\n", &mut line).unwrap_err();
        assert_eq!(fault, Fault::Late { seconds: 1 });
        assert!(ends("300.5"));
        let mut gone = talk(&shell("read -r x"), TO_READ).unwrap();
        let fault = gone.ask("a\n", &mut line).unwrap_err();
        assert!(matches!(fault, Fault::Ended { .. }), "{fault}");
    }
}
