//! The external tools of all commands: where each is searched, its version, and what needs it.

mod catalogue;
mod search;
#[cfg(test)]
mod tests;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use schemars::JsonSchema;
use serde::Serialize;

use catalogue::{TOOLS, Tool};
use search::{locate, numbers, version};

/// Whether a tool can be used.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum State {
    /// It is there, in a version that works.
    Found,
    /// It is not there.
    Missing,
    /// It is there, in a version that does not work.
    TooOld,
    /// It is there and does not report its version.
    Broken,
    /// It is in `.tools/bin`, where other commands do not look.
    OutsidePath,
}

/// State of one tool.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Finding {
    /// Its name.
    pub name: &'static str,
    /// Whether it can be used.
    pub state: State,
    /// Whether the main commands need it.
    pub required: bool,
    /// The version that it reports.
    pub version: Option<String>,
    /// The first version that works.
    pub minimum: &'static str,
    /// Its place.
    pub path: Option<PathBuf>,
    /// The problem, if any.
    pub problem: Option<String>,
    /// What needs it.
    pub disables: &'static str,
    /// How to install it.
    pub remedy: &'static str,
}

impl Finding {
    /// Whether it is required and cannot be used.
    #[must_use]
    pub fn is_lacking(&self) -> bool {
        self.required && self.state != State::Found
    }
}

/// Environment of the search.
struct Surroundings<'a> {
    /// Value of an environment variable.
    variable: &'a dyn Fn(&str) -> Option<OsString>,
    /// The current folder.
    folder: PathBuf,
}

/// The state of every tool in the environment of this process.
#[must_use]
pub fn examine() -> Vec<Finding> {
    examine_in(&Surroundings {
        variable: &|name| std::env::var_os(name),
        folder: std::env::current_dir().unwrap_or_default(),
    })
}

fn examine_in(around: &Surroundings<'_>) -> Vec<Finding> {
    TOOLS.iter().map(|tool| find(tool, around)).collect()
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
                    "it is in {}, which is not in PATH: run the command through make, or add \
                     that folder to PATH",
                    place.program.parent().unwrap_or(Path::new("/")).display()
                ));
            }
        }
    }
    finding.path = Some(place.program);
    finding
}
