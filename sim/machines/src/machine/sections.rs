//! Parts of a machine's file.

use potamoi_formats::config::ConfigError;
use potamoi_formats::document::{Value, Wrong};
use potamoi_formats::nearest::nearest;

use super::MachineError;
use super::known::presets;

/// Key of the preset whose configuration the file changes.
pub(super) const PRESET: &str = "preset";
/// Sections beside the configuration.
pub(super) const SYSTEM: &str = "system";
pub(super) const RENDER: &str = "render";
const PATH: &str = "path";
/// Key of `[render]` with the effects that are left out.
pub(super) const WITHOUT: &str = "without";
/// Key of the assumed clock, and the value that gives it back to synthesis.
pub(super) const CLOCK: &str = "clock_ghz";
pub(super) const REACHED: &str = "reached";

/// A section of a machine's file beside the configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Section {
    /// `[system]`: GPU, memory, array and buffers.
    System,
    /// `[render]`: how a scene is rendered.
    Render,
    /// `[path]`: which frames of a path are rendered, and which are warped.
    Path,
}

impl Section {
    /// All sections.
    pub const ALL: [Self; 3] = [Self::System, Self::Render, Self::Path];

    /// Its name in the file.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::System => SYSTEM,
            Self::Render => RENDER,
            Self::Path => PATH,
        }
    }
}

/// A file by section.
pub(super) struct Parts {
    /// Keys of the configuration over those of the preset; `None` where the file has neither.
    pub(super) hardware: Option<Value>,
    pub(super) system: Option<Value>,
    pub(super) render: Option<Value>,
    pub(super) path: Option<Value>,
}

impl Parts {
    pub(super) fn of(name: &str, document: Value) -> Result<Self, MachineError> {
        let take = |of: &str| document.get(of).cloned();
        let (system, render, path) = (take(SYSTEM), take(RENDER), take(PATH));
        let base = take(PRESET).map(|given| preset(name, &given)).transpose()?;
        let rest = [PRESET, SYSTEM, RENDER, PATH]
            .into_iter()
            .fold(document, Value::without);
        let is_empty = matches!(&rest, Value::Map(all) if all.is_empty());
        let hardware = match (base, is_empty) {
            (None, true) => None,
            (None, false) => Some(rest),
            (Some(base), _) => Some(rest.over(base)),
        };
        Ok(Self {
            hardware,
            system,
            render,
            path,
        })
    }
}

/// The document of the preset that a file names.
fn preset(name: &str, given: &Value) -> Result<Value, MachineError> {
    let found = presets().iter().find(|own| given.text() == Some(own.name));
    if let Some(found) = found {
        return Ok(found.document.clone());
    }
    let names: Vec<&str> = presets().iter().map(|own| own.name).collect();
    let near = given
        .text()
        .and_then(|text| nearest(text, names.iter().copied()));
    let near = near.map_or_else(String::new, |near| format!("; did you mean `{near}`?"));
    let expected = format!("one of {}{near}", names.join(", "));
    let wrong = Wrong::found(given.shown(), expected).under(PRESET);
    Err(MachineError::wrong(name, &wrong))
}

/// A list of the configuration's keys, with those beside it and the nearest of them.
fn with_keys(field: &str, message: String) -> String {
    let start = format!("one of {CLOCK}");
    let own = [PRESET, SYSTEM, RENDER, PATH];
    if !message.contains(&start) {
        return message;
    }
    let all = message.replacen(&start, &format!("one of {}, {CLOCK}", own.join(", ")), 1);
    match nearest(field, own).filter(|_| !message.contains("did you mean")) {
        Some(near) => format!("{all}; did you mean `{near}`?"),
        None => all,
    }
}

/// An error of the configuration, in which the keys beside it are known too.
pub(super) fn with_sections(error: ConfigError) -> ConfigError {
    match error {
        ConfigError::Parse {
            origin,
            field,
            message,
        } => ConfigError::Parse {
            origin,
            message: with_keys(&field, message),
            field,
        },
        other => other,
    }
}
