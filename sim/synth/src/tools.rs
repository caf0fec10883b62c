//! Location and execution of Yosys and OpenSTA.

use std::path::Path;
use std::process::Command;

use potamoi_verilated::child::{self, Fault};

use super::SynthError;
use super::error::CHECK_LIBRARY;

/// Yosys of the Python package of that name, as tools/setup starts it: `--version` or a script.
const PYOSYS: &str = "pyosys";
pub(super) const SYNTH: &str = "synth.ys";
pub(super) const FINISH: &str = "finish.ys";
pub(super) const TIMING: &str = "timing.tcl";
/// Largest quoted output of a failed program, in bytes.
const SAID: usize = 2000;

/// Programs that map Verilog to cells and time the netlist.
#[derive(Debug, Clone)]
pub struct Tools {
    /// Whether Yosys is the Python package.
    pub(super) is_pyosys: bool,
    /// Version as reported: `Yosys 0.23 (...)`.
    pub yosys: String,
    /// Version as reported: `2.0.17`.
    pub opensta: String,
}

impl Tools {
    /// Finds both: `pyosys` or else `yosys`, and `sta`.
    ///
    /// # Errors
    /// One is missing.
    pub fn find() -> Result<Self, SynthError> {
        let mut tools = Self::yosys_alone()?;
        tools.opensta = says("sta", &["-version"])?.ok_or(SynthError::MissingTool {
            tool: "sta",
            disables: "the clock of a netlist",
            remedy: "tools/setup synth, or: apt-get install opensta",
        })?;
        Ok(tools)
    }

    /// Finds Yosys alone, which is enough for a gate-level netlist.
    ///
    /// # Errors
    /// It is missing.
    pub fn yosys_alone() -> Result<Self, SynthError> {
        let pyosys = says(PYOSYS, &["--version"])?;
        let is_pyosys = pyosys.is_some();
        let yosys = match pyosys {
            Some(found) => Some(found),
            None => says("yosys", &["-V"])?,
        };
        let yosys = yosys.ok_or(SynthError::MissingTool {
            tool: "yosys",
            disables: "synthesis",
            remedy: "tools/setup synth, or: apt-get install yosys",
        })?;
        let yosys = yosys.replace("Yosys Yosys", "Yosys");
        Ok(Self {
            is_pyosys,
            yosys,
            opensta: String::new(),
        })
    }

    /// Major and minor version of Yosys.
    pub(super) fn yosys_version(&self) -> (u32, u32) {
        let numbers = self.yosys.split([' ', '+']).find(|w| w.contains('.'));
        let mut numbers = numbers.unwrap_or_default().split('.').map(str::parse);
        let mut next = || numbers.next().and_then(Result::ok).unwrap_or(0);
        (next(), next())
    }

    /// Runs a Yosys script in `folder`.
    pub(super) fn yosys(&self, folder: &Path, script: &str, unit: &str) -> Result<(), SynthError> {
        let mut yosys = Command::new(if self.is_pyosys { PYOSYS } else { "yosys" });
        if !self.is_pyosys {
            yosys.args(["-q", "-s"]);
        }
        yosys.arg(script);
        run(yosys, folder, ("yosys", CHECK_LIBRARY), unit).map(drop)
    }

    /// Runs the OpenSTA script in `folder`. Returns its output.
    pub(super) fn sta(&self, folder: &Path, unit: &str) -> Result<String, SynthError> {
        let mut sta = Command::new("sta");
        sta.args(["-no_splash", "-exit", TIMING]);
        run(sta, folder, ("sta", CHECK_LIBRARY), unit)
    }
}

/// First line of a program's output, on standard output if possible; `None` where it is not
/// installed or fails.
///
/// # Errors
/// It does not answer in time or prints nothing, or a signal ends it.
pub(super) fn says(
    program: &'static str,
    arguments: &[&str],
) -> Result<Option<String>, SynthError> {
    let mut command = Command::new(program);
    match child::says(command.args(arguments), child::TO_ANSWER) {
        Ok(None) => Ok(None),
        Ok(Some(text)) => match text.lines().next().map(str::trim) {
            Some(line) if !line.is_empty() => Ok(Some(line.to_owned())),
            _ => Err(left_nothing(program, "its version", "prints nothing")),
        },
        Err(Fault::Missing { .. }) => Ok(None),
        Err(fault) => Err(broken(program, "its version", fault)),
    }
}

/// Error of a program that succeeds without a result.
pub(super) fn left_nothing(tool: &'static str, unit: &str, what: &str) -> SynthError {
    let what = what.to_owned();
    broken(tool, unit, Fault::Nothing { what })
}

/// Error of a program that is broken, whatever its input.
pub(super) fn broken(tool: &'static str, unit: &str, fault: Fault) -> SynthError {
    SynthError::Broken {
        tool,
        unit: unit.to_owned(),
        fault,
    }
}

/// Runs a program in `folder`. Returns its output. `remedy` names what to check where it fails.
pub(super) fn run(
    mut command: Command,
    folder: &Path,
    (tool, remedy): (&'static str, &'static str),
    unit: &str,
) -> Result<String, SynthError> {
    let fail = |said: String| SynthError::Tool {
        tool,
        unit: unit.to_owned(),
        said,
        remedy,
    };
    // Temporary files of a program that is killed go with the folder.
    command.current_dir(folder).env("TMPDIR", folder);
    let output =
        child::run(&command, child::TO_BUILD).map_err(|fault| broken(tool, unit, fault))?;
    let text = [&*output.out, &*output.err].concat();
    let text = String::from_utf8_lossy(&text).into_owned();
    // OpenSTA goes on after errors, and ends well.
    let is_wrong = |line: &str| line.starts_with("Error");
    if output.status.success() && !text.lines().any(is_wrong) {
        return Ok(text);
    }
    let wrong = text
        .lines()
        .find(|line| is_wrong(line) || line.starts_with("ERROR"));
    let mut last = text.len().saturating_sub(SAID);
    while !text.is_char_boundary(last) {
        last += 1;
    }
    Err(fail(wrong.unwrap_or(text[last..].trim()).to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_releases_are_read() {
        for (said, expected) in [
            ("Yosys 0.23 (git sha1 7ce5011c24b)", (0, 23)),
            ("Yosys 0.70+12 (git sha1 0)", (0, 70)),
            ("Yosys", (0, 0)),
        ] {
            let tools = Tools {
                is_pyosys: false,
                yosys: said.to_owned(),
                opensta: String::new(),
            };
            assert_eq!(tools.yosys_version(), expected, "{said}");
        }
    }

    /// A program that goes on after an error, and what is said of it.
    #[test]
    fn a_failure_names_what_to_look_at() {
        let mut echo = Command::new("echo");
        echo.arg("Error: cells.lib line 7, no such pin");
        let folder = std::env::temp_dir();
        let error = run(echo, &folder, ("sta", CHECK_LIBRARY), "vector_unit");
        let said = error.map_err(|e| e.to_string()).err().unwrap_or_default();
        let start = "sta failed on vector_unit: Error: cells.lib line 7, no such pin; check the cell \
                     descriptions of the library";
        assert!(said.starts_with(start), "{said}");
    }
}
