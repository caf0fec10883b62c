//! The programs.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;
use std::time::Duration;

use potamoi_verilated::child::{self, Done, Fault};
use serde::Serialize;

use crate::{Judge, MutateError};

/// Time limit of one run of a program other than a bench.
const LIMIT: Duration = Duration::from_secs(1800);
/// Lines that are quoted of a program that fails.
const LINES: usize = 12;

/// Programs that are there.
#[derive(Debug, Clone, Serialize)]
pub struct Tools {
    /// First line of `yosys -V`.
    pub yosys: String,
    /// That of the others, by name.
    pub others: BTreeMap<String, String>,
    /// Those of the proofs, if they judge.
    #[serde(skip)]
    pub proofs: Option<potamoi_prove::Tools>,
}

impl Tools {
    /// Finds what these judges need.
    ///
    /// # Errors
    /// The name of one that is missing, and how to get it.
    pub fn find(judges: &BTreeSet<Judge>) -> Result<Self, MutateError> {
        let needed = [
            ("yosys", "-V", "apt-get install yosys"),
            ("yosys-abc", "-h", "apt-get install yosys"),
            ("verilator", "--version", "apt-get install verilator"),
            ("iverilog", "-V", "apt-get install iverilog"),
            ("make", "--version", "apt-get install make"),
        ];
        let mut versions = BTreeMap::new();
        for (tool, argument, remedy) in needed {
            let mut command = Command::new(tool);
            match child::run(command.arg(argument), child::TO_ANSWER) {
                Ok(done) => {
                    let version = text(&done).lines().next().unwrap_or_default().to_owned();
                    versions.insert(tool.to_owned(), version);
                }
                Err(Fault::Missing { .. }) => return Err(MutateError::Missing { tool, remedy }),
                Err(fault) => return Err(broken(tool, "its version", fault)),
            }
        }
        let proofs = potamoi_prove::Tools::find();
        if let Ok(found) = &proofs {
            versions.insert("yices-smt2".to_owned(), found.yices.clone());
        }
        let proving = [Judge::Proofs, Judge::UnitMiter, Judge::Operands];
        let proves = proving.iter().any(|judge| judges.contains(judge));
        let proofs = proves.then_some(proofs);
        let proofs = proofs.transpose()?;
        Ok(Self {
            yosys: versions.remove("yosys").unwrap_or_default(),
            others: versions,
            proofs,
        })
    }

    /// Runs a Yosys script in a folder.
    pub(crate) fn yosys(
        &self,
        folder: &Path,
        lines: &[String],
        what: &str,
    ) -> Result<(), MutateError> {
        let script = folder.join("script.ys");
        write(&script, &format!("{}\n", lines.join("\n")))?;
        let mut command = Command::new("yosys");
        command.args(["-q", "-s", "script.ys"]).current_dir(folder);
        succeed(&command, "yosys", what).map(|_| ())
    }
}

/// Runs a program that has to succeed, and returns its output.
pub(crate) fn succeed(command: &Command, tool: &str, what: &str) -> Result<String, MutateError> {
    let done = run(command, tool, what)?;
    let said = text(&done);
    match done.status.success() {
        true => Ok(said),
        false => Err(no_result(tool, what, &said)),
    }
}

pub(crate) fn run(command: &Command, tool: &str, what: &str) -> Result<Done, MutateError> {
    child::run(command, LIMIT).map_err(|fault| broken(tool, what, fault))
}

/// What a program says.
pub(crate) fn text(done: &Done) -> String {
    let all = [&done.out[..], &done.err].concat();
    String::from_utf8_lossy(&all).into_owned()
}

pub(crate) fn write(path: &Path, text: &str) -> Result<(), MutateError> {
    let file = |error| MutateError::File {
        path: path.to_owned(),
        error,
    };
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(file)?;
    }
    std::fs::write(path, text).map_err(file)
}

pub(crate) fn read(path: &Path) -> Result<String, MutateError> {
    std::fs::read_to_string(path).map_err(|error| MutateError::File {
        path: path.to_owned(),
        error,
    })
}

pub(crate) fn broken(tool: &str, what: &str, fault: Fault) -> MutateError {
    MutateError::Broken {
        tool: tool.to_owned(),
        what: what.to_owned(),
        fault,
    }
}

pub(crate) fn no_result(tool: &str, what: &str, said: &str) -> MutateError {
    let lines: Vec<&str> = said.trim().lines().collect();
    let last = lines.len().saturating_sub(LINES);
    MutateError::NoResult {
        tool: tool.to_owned(),
        what: what.to_owned(),
        said: lines[last..].join("\n"),
    }
}
