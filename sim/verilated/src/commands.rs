//! Commands of the tools: compiler flags common to all models, and reports of failures.

use crate::{Error, Toolchain, child, store::Key, toolchain::SEE_DOCTOR};
use std::{fs, path::Path, process::Command};

pub(crate) const PRELUDE: &str = include_str!("cpp/prelude.h");
pub(crate) const PRELUDE_FILE: &str = "potamoi_prelude.h";

/// Longest tool output in an error, in bytes.
const OUTPUT_LIMIT: usize = 8192;

/// Flags for every C++ file; `-fno-gnu-unique` lets a library be unloaded, and hidden symbols
/// keep the run-time code of two models apart.
pub(crate) fn common_flags(vcd: bool) -> Vec<&'static str> {
    let mut flags = vec![
        "-std=gnu++17",
        "-fPIC",
        "-w",
        "-pthread",
        "-fvisibility=hidden",
        "-DVL_TIME_CONTEXT",
        "-DVL_USER_FATAL",
        "-DVL_USER_STOP",
        "-DVL_USER_FINISH",
        "-DVM_SC=0",
        "-DVM_COVERAGE=0",
        "-DVM_TIMING=0",
        "-DVM_TRACE_FST=0",
        "-DVM_TRACE_SAIF=0",
        "-include",
        PRELUDE_FILE,
    ];
    flags.extend(if vcd {
        ["-DVM_TRACE=1", "-DVM_TRACE_VCD=1"]
    } else {
        ["-DVM_TRACE=0", "-DVM_TRACE_VCD=0"]
    });
    flags
}

/// Key of something compiled with these tools and flags.
pub(crate) fn tools_key(kind: &str, tools: &Toolchain, flags: &[&str]) -> Key {
    Key::new(kind)
        .with(std::env::consts::ARCH)
        .with(tools.verilator_version())
        .with(&tools.verilator_root().to_string_lossy())
        .with(tools.cxx_version())
        .with(&tools.cxx_words().join("\0"))
        .with(PRELUDE)
        .with(&flags.join(" "))
}

/// The compiler, run in `folder` with the common flags of a model's C++ files.
pub(crate) fn compiler(tools: &Toolchain, folder: &Path, vcd: bool) -> Command {
    let mut command = tools.cxx();
    let include = tools.verilator_root().join("include");
    command
        .current_dir(folder)
        // Its temporary files go with the folder, even if it is killed.
        .env("TMPDIR", folder)
        .args(common_flags(vcd))
        .arg("-I.");
    // clang has no unique symbols to turn off and does not know the flag.
    if !tools.cxx_version().contains("clang") {
        command.arg("-fno-gnu-unique");
    }
    for folder in [include.join("vltstd"), include] {
        command.arg("-I").arg(folder);
    }
    command
}

pub(crate) fn write_prelude(folder: &Path) -> Result<(), Error> {
    write(&folder.join(PRELUDE_FILE), PRELUDE)
}

pub(crate) fn write(path: &Path, text: &str) -> Result<(), Error> {
    fs::write(path, text).map_err(|e| Error::io("write", path, &e))
}

/// Runs all commands at once, and reports the first failure.
pub(crate) fn all(commands: Vec<Command>, doing: &str) -> Result<(), Error> {
    std::thread::scope(|scope| {
        let jobs: Vec<_> = commands
            .into_iter()
            .map(|c| scope.spawn(move || run(c, doing)))
            .collect();
        let results: Vec<_> = jobs.into_iter().map(|j| j.join()).collect();
        results
            .into_iter()
            .try_for_each(|r| r.unwrap_or_else(|p| std::panic::resume_unwind(p)))
    })
}

/// Runs Verilator, which refuses faulty Verilog.
pub(crate) fn read(command: &Command, doing: &str) -> Result<(), Error> {
    let done = child::run(command, child::TO_READ)
        .map_err(|fault| broken(command, doing, fault.to_string()))?;
    if done.status.success() {
        return Ok(());
    }
    Err(Error::Tool {
        tool: command.get_program().to_string_lossy().into_owned(),
        doing: doing.to_string(),
        status: done.status.to_string(),
        output: said(&done),
    })
}

/// Runs the compiler on Verilator's output; a refusal is no fault of the user's input.
pub(crate) fn run(command: Command, doing: &str) -> Result<(), Error> {
    let done = child::run(&command, child::TO_BUILD)
        .map_err(|fault| broken(&command, doing, fault.to_string()))?;
    if done.status.success() {
        return Ok(());
    }
    let problem = format!("{}:\n{}\n", done.status, said(&done));
    Err(broken(&command, doing, problem))
}

pub(crate) fn broken(command: &Command, doing: &str, problem: String) -> Error {
    Error::Broken {
        tool: command.get_program().to_string_lossy().into_owned(),
        doing: doing.to_string(),
        problem,
        remedy: SEE_DOCTOR,
    }
}

fn said(done: &child::Done) -> String {
    let said = [&*done.err, &*done.out].concat();
    shorten(String::from_utf8_lossy(&said).trim())
}

/// Start and end of a long text: the first error matters, the last line counts them.
fn shorten(text: &str) -> String {
    if text.len() <= OUTPUT_LIMIT {
        return text.to_string();
    }
    let head: String = text.chars().take(OUTPUT_LIMIT * 3 / 4 / 4).collect();
    let tail: String = text.chars().rev().take(OUTPUT_LIMIT / 4 / 4).collect();
    let tail: String = tail.chars().rev().collect();
    format!("{head}\n[...]\n{tail}")
}
