//! `potamoi doctor`: the external tools installed, and the commands that lack one.

use comfy_table::{Table, presets};
use potamoi_synth::toolbox::{Finding, State, examine};
use schemars::JsonSchema;
use serde::Serialize;

use crate::failure::Failure;
use crate::published::{Published, shape};
use crate::report_files::ReportFiles;
use crate::stdout::say;

/// Version of the JSON report.
const FORMAT_VERSION: u32 = 1;

/// The report of `--json`.
pub(crate) const REPORT: Published = Published {
    command: "doctor",
    version: FORMAT_VERSION,
    shape: shape::<Report>,
};

#[derive(Debug, Serialize, JsonSchema)]
struct Report {
    format_version: u32,
    command: &'static str,
    /// Whether every required tool is usable.
    complete: bool,
    tools: Vec<Finding>,
}

const fn words(state: State) -> &'static str {
    match state {
        State::Found => "found",
        State::Missing => "missing",
        State::TooOld => "too old",
        State::Broken => "broken",
        State::OutsidePath => "not in PATH",
    }
}

/// Prints a table of the tools on standard output, and writes the report where asked for.
///
/// # Errors
/// [`Failure::Tools`] when a required tool cannot be used, [`Failure::File`] when the report cannot
/// be written.
pub(crate) fn run(files: &ReportFiles) -> Result<(), Failure> {
    files.prepare([])?;
    let tools = examine();
    let lacking: Vec<_> = tools.iter().filter(|tool| tool.is_lacking()).collect();
    let lacking: Vec<_> = lacking.iter().map(|tool| tool.name).collect();
    let report = Report {
        format_version: FORMAT_VERSION,
        command: "doctor",
        complete: lacking.is_empty(),
        tools,
    };
    say!("{}", text(&report.tools).trim_end());
    files.write(&report)?;
    match report.complete {
        true => Ok(()),
        false => Err(Failure::Tools(format!(
            "required tools cannot be used: {}; the lines above tell how to install each",
            lacking.join(", ")
        ))),
    }
}

fn text(tools: &[Finding]) -> String {
    let mut table = Table::new();
    table.load_preset(presets::NOTHING);
    table.set_header(["tool", "state", "version", "minimum", "path"]);
    for tool in tools {
        table.add_row([
            tool.name.to_owned(),
            words(tool.state).to_owned(),
            tool.version.clone().unwrap_or_else(|| "-".into()),
            tool.minimum.to_owned(),
            tool.path
                .as_ref()
                .map_or_else(|| "-".into(), |p| p.display().to_string()),
        ]);
    }
    let mut text = format!("{table}\n");
    for tool in tools.iter().filter(|t| t.state != State::Found) {
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
            "  without it: {}\n  to install: {}\n",
            tool.disables, tool.remedy
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lacking_tool_is_told_with_what_it_disables() {
        let tool = Finding {
            name: "yosys",
            state: State::TooOld,
            required: true,
            version: Some("0.9".to_owned()),
            minimum: "0.23",
            path: None,
            problem: Some("0.9 is too old".to_owned()),
            disables: "synth",
            remedy: "apt-get install yosys",
        };
        let text = text(&[tool]);
        for part in [
            "too old",
            "yosys (required): 0.9",
            "without it: synth",
            "apt-get",
        ] {
            assert!(text.contains(part), "{part}: {text}");
        }
    }
}
