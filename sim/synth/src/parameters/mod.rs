//! Reads files of synthesised parameters, for system models.

mod check;
mod lookup;
mod synthesised;
#[cfg(test)]
mod tests;

use std::path::Path;

use potamoi_formats::config::Config;
use potamoi_formats::document::{self, Value};

use super::report::FORMAT_VERSION;
use super::{SynthError, SynthReport};

pub use synthesised::Synthesised;

/// The command that writes such a file.
const REMEDY: &str = "potamoi synth --json FILE";
const PAPER: &str = include_str!("../../../../synth/paper-asap7.json");
const FIELDS: &str = include_str!("../../../../synth/fields-asap7.json");
const RECORDS: &str = include_str!("../../../../synth/records-asap7.json");
/// Size limit in bytes: a hundred times the files that come with the program.
const LIMIT: u64 = 2 << 20;

impl SynthReport {
    /// The files that come with the program, in ASAP7 at 7 nm: the preset `paper`, whose gathering
    /// unit ran entries of eight vertices, and the preset `fields`.
    ///
    /// # Errors
    /// A file fails the checks of [`SynthReport::read`].
    pub fn checked_in() -> Result<[Self; 2], SynthError> {
        Ok([
            Self::embedded("synth/paper-asap7.json", PAPER)?,
            Self::embedded("synth/fields-asap7.json", FIELDS)?,
        ])
    }

    /// The preset `paper`'s gathering unit, run with splat records.
    ///
    /// # Errors
    /// As [`SynthReport::checked_in`].
    pub fn of_records() -> Result<Self, SynthError> {
        Self::embedded("synth/records-asap7.json", RECORDS)
    }

    fn embedded(name: &str, text: &str) -> Result<Self, SynthError> {
        Self::parse(text).map_err(|why| SynthError::Parameters {
            path: name.into(),
            why,
            remedy: REMEDY,
        })
    }

    /// Reads and checks a file that `potamoi synth --json` wrote.
    ///
    /// # Errors
    /// It cannot be read, has another version, lacks a field, has an unknown one, or its figures
    /// contradict each other.
    pub fn read(path: &Path) -> Result<Self, SynthError> {
        let fail = |why: String| SynthError::Parameters {
            path: path.to_owned(),
            why,
            remedy: REMEDY,
        };
        let text = potamoi_base::files::read_text(path, LIMIT).map_err(|e| fail(e.to_string()))?;
        Self::parse(&text).map_err(fail)
    }

    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let document =
            document::json(text.as_bytes()).map_err(|e| format!("no parameters: {e}"))?;
        let version = document.get("format_version").and_then(Value::whole);
        if version != Some(FORMAT_VERSION.into()) {
            let found = version.map_or("missing".to_owned(), |v| v.to_string());
            return Err(format!("format_version {found}, expected {FORMAT_VERSION}"));
        }
        let report: Self = document.read().map_err(|e| e.to_string())?;
        // Readers of types within types pass keys over that neither has.
        let kept = serde_json::to_vec(&report).map_err(|e| e.to_string())?;
        let kept = document::json(&kept).map_err(|e| e.to_string())?;
        if let Some(lost) = document.lost_in(&kept) {
            return Err(lost.to_string());
        }
        report.check()?;
        Ok(report)
    }

    /// Checks that it is of this configuration; `path` names it in errors.
    ///
    /// # Errors
    /// It is of another configuration.
    pub fn of(self, config: &Config, path: &Path) -> Result<Self, SynthError> {
        match self.configuration == config.hash() {
            true => Ok(self),
            false => Err(SynthError::Parameters {
                path: path.to_owned(),
                why: format!(
                    "it is of configuration {}, expected {}",
                    self.configuration,
                    config.hash()
                ),
                remedy: REMEDY,
            }),
        }
    }

    /// Whether it is of this configuration.
    #[must_use]
    pub fn is_of(&self, config: &Config) -> bool {
        self.configuration == config.hash()
    }
}
