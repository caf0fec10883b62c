//! `--engine dask`: the runner of the Python package spreads points over workers of Dask distributed, and
//! hands back the line of each.

use std::io::{BufRead as _, BufReader, Write as _};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use potamoi_explore::Progress;
use potamoi_machines::sweep::{MissingPoint, Plan, Session, Swept};
use potamoi_synth::SynthError;
use potamoi_verilated::{cache, child};
use serde::{Deserialize, Serialize};

use crate::failure::Failure;
use crate::stdout;

/// Environment variable that names the Python of the runner, and what runs without it.
const PYTHON: &str = "POTAMOI_PYTHON";
const DEFAULT_PYTHON: &str = "python3";
/// Prints which of the packages that the runner needs are missing, without importing any.
const LACKING: &str = "from importlib.util import find_spec as f\n\
                       print(*[n for n in ('numpy', 'potamoi', 'distributed') if not f(n)])";
/// The runner's module.
const MODULE: &str = "potamoi.sweep";
/// What installs all that the runner needs.
const REMEDY: &str = "install it with pip install './python[dask]' at the top of Potamoi's sources, or name a \
                      Python that has it in POTAMOI_PYTHON";
/// Version of what the runner is told.
const FORMAT_VERSION: u32 = 1;

/// What the runner is told, in one line of its standard input, which stays open as long as this program lives.
#[derive(Serialize)]
struct Job<'a> {
    format_version: u32,
    scheduler: &'a str,
    program: PathBuf,
    plan: &'a Path,
    /// Files that the plan reads.
    files: Vec<PathBuf>,
    /// Folder of counted work.
    counted: PathBuf,
    points: Vec<MissingPoint>,
}

/// What the runner says in a line that is none of the journal.
#[derive(Deserialize)]
#[serde(untagged)]
enum Said {
    Note {
        note: String,
    },
    Error {
        error: String,
        /// Whether the command line is at fault, and no tool.
        is_input: bool,
    },
}

/// Evaluates all points that a folder lacks on the workers of a scheduler.
pub(super) fn run(
    plan: &Plan,
    file: &Path,
    folder: &Path,
    scheduler: &str,
    progress: &dyn Progress,
) -> Result<Swept, Failure> {
    let mut session = plan.session(folder)?;
    let points = session.missing();
    progress.expect(points.len() as u64);
    if points.is_empty() {
        return Ok(session.finish()?);
    }
    let python = python()?;
    let own = std::env::current_exe();
    let job = Job {
        format_version: FORMAT_VERSION,
        scheduler,
        program: own.map_err(|error| broken(&error))?,
        plan: file,
        files: plan.files().into_iter().collect(),
        counted: cache::folder("work").map_err(SynthError::from)?,
        points,
    };
    let mut runner = start(python, &job)?;
    let told = listen(&mut runner, &mut session, progress);
    if told.is_err() {
        // What it would still say is not heard.
        let _ = runner.kill();
    }
    let ended = runner.wait().map_err(|error| broken(&error));
    told?;
    match ended? {
        status if status.success() => Ok(session.finish()?),
        status => Err(broken(&format!("it ended with {status}"))),
    }
}

/// Python with all that the runner needs, and the package beside the program first in its path.
fn python() -> Result<Command, Failure> {
    let name = std::env::var_os(PYTHON).filter(|own| !own.is_empty());
    let mut command = Command::new(name.unwrap_or_else(|| DEFAULT_PYTHON.into()));
    if let Some(package) = package() {
        let known = std::env::var_os("PYTHONPATH").unwrap_or_default();
        let known = std::env::split_paths(&known).filter(|own| !own.as_os_str().is_empty());
        let all = std::env::join_paths([package].into_iter().chain(known));
        command.env("PYTHONPATH", all.map_err(|error| broken(&error))?);
    }
    let said = match child::run(
        &with_arguments(&command, &["-c", LACKING]),
        child::TO_ANSWER,
    ) {
        Ok(done) if done.status.success() => String::from_utf8_lossy(&done.out).into_owned(),
        Ok(done) => return Err(broken(&String::from_utf8_lossy(&done.err).trim())),
        Err(fault) => return Err(broken(&fault)),
    };
    match said.trim() {
        "" => Ok(command),
        lacking => {
            let python = command.get_program().to_string_lossy().into_owned();
            let lacking = lacking.replace(' ', ", ");
            Err(Failure::Tools(format!(
                "--engine dask: {python} lacks {lacking}: {REMEDY}"
            )))
        }
    }
}

fn with_arguments(of: &Command, arguments: &[&str]) -> Command {
    let mut command = Command::new(of.get_program());
    for (name, value) in of.get_envs() {
        command.env(name, value.unwrap_or_default());
    }
    command.args(arguments);
    command
}

/// The folder of the Python package beside the program, or at the top of the sources that it was built from.
fn package() -> Option<PathBuf> {
    let own = std::env::current_exe().ok()?;
    let folder = own.parent()?;
    let places = [folder.to_owned(), folder.join("../..")];
    let mut packages = places.iter().map(|own| own.join("python"));
    packages.find(|own| own.join("potamoi/sweep/__main__.py").is_file())
}

fn start(python: Command, job: &Job<'_>) -> Result<Child, Failure> {
    let mut command = with_arguments(&python, &["-m", MODULE]);
    command.stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut runner = command.spawn().map_err(|error| broken(&error))?;
    let mut text = serde_json::to_vec(job).map_err(|error| broken(&error))?;
    text.push(b'\n');
    let written = match &mut runner.stdin {
        Some(pipe) => pipe.write_all(&text).and_then(|()| pipe.flush()),
        None => Ok(()),
    };
    match written {
        Ok(()) => Ok(runner),
        Err(error) => {
            let _ = runner.kill();
            // It tells itself why it ended, on standard error.
            std::thread::sleep(Duration::from_millis(1));
            let _ = runner.wait();
            Err(broken(&error))
        }
    }
}

/// Writes all lines of the runner into the journal, until it ends.
fn listen(
    runner: &mut Child,
    session: &mut Session<'_>,
    progress: &dyn Progress,
) -> Result<(), Failure> {
    let Some(pipe) = runner.stdout.take() else {
        return Ok(());
    };
    for line in BufReader::new(pipe).lines() {
        let line = line.map_err(|error| broken(&error))?;
        match serde_json::from_str(&line) {
            Ok(Said::Note { note }) => stdout::remark(format_args!("{note}")),
            Ok(Said::Error { error, is_input }) => {
                return Err(match is_input {
                    true => Failure::Usage(error),
                    false => Failure::Tools(error),
                });
            }
            Err(_) => {
                if session.accept(&line)? {
                    progress.advance(1);
                }
            }
        }
    }
    Ok(())
}

fn broken(why: &dyn std::fmt::Display) -> Failure {
    Failure::Tools(format!(
        "--engine dask: the runner does not work: {why}; {REMEDY}"
    ))
}
