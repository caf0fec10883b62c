//! `potamoi doctor`: the external tools installed, and the commands that lack one.

mod search;
mod tools;

use std::path::{Path, PathBuf};

use comfy_table::{Table, presets};
use serde::Serialize;
use thiserror::Error;

use crate::files::{self, FileError};
use crate::stdout::say;
use search::{Surroundings, locate, numbers, version};
use tools::{TOOLS, Tool};

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

/// Why `doctor` fails.
#[derive(Debug, Error)]
pub(crate) enum DoctorError {
    #[error("required and not usable: {0}; the lines above say how to get each")]
    Missing(String),
    #[error("cannot describe the tools as JSON: {0}")]
    Json(#[from] serde_json::Error),
    #[error(transparent)]
    File(#[from] FileError),
}

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

/// State of one tool.
#[derive(Debug, Serialize)]
struct Finding {
    name: &'static str,
    state: State,
    required: bool,
    version: Option<String>,
    minimum: &'static str,
    path: Option<PathBuf>,
    /// The problem, if any.
    problem: Option<String>,
    disables: &'static str,
    remedy: &'static str,
}

#[derive(Debug, Serialize)]
struct Report {
    format_version: u32,
    /// Whether every required tool is usable.
    complete: bool,
    tools: Vec<Finding>,
}

/// Prints a table of the tools on standard output, and writes the JSON report where asked for.
///
/// # Errors
/// [`DoctorError::Missing`] when a required tool cannot be used, [`DoctorError::File`] when the
/// report cannot be written.
pub(crate) fn run(json: Option<&Path>) -> Result<(), DoctorError> {
    files::prepare([json.map(Path::to_path_buf).as_ref()])?;
    let report = examine(&Surroundings {
        variable: &|name| std::env::var_os(name),
        folder: std::env::current_dir().unwrap_or_default(),
    });
    say!("{}", text(&report).trim_end());
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

#[cfg(test)]
mod tests;
