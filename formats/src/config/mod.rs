//! The configuration: every parameter of the generated hardware, from TOML.
//!
//! Unknown fields are refused. A parsed configuration is checked against [`rules`]; the error names
//! the broken rule, the field, its value and the allowed values.

mod breaches;
mod clock;
mod derived;
mod exponential;
mod gu;
mod identity;
mod overlay;
mod places;
pub mod rules;
mod su;
mod vu;

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use thiserror::Error;

use crate::document::{self, Value};

pub use breaches::{RuleBreach, RuleBreaches};
pub use exponential::{Engine, ExpBase, ExpConfig, ExpForm, ExpOutput, Offers, PieceWidths};
pub use gu::{
    EntryKind, ExtraPorts, GuConfig, Modes, MvoxelConfig, Organisation, RitConfig, RitPairs,
    RitPath, Sums, WeightTrust,
};
pub use overlay::{Layer, overlay};
pub use su::{NO_SPLAT_UNIT, SplatOpacity, SuConfig};
pub use vu::{OperandWidths, VuConfig, VuSamples};

/// The paper's sizes, the default of every command.
pub(crate) const PAPER_PRESET: &str = include_str!("../../../configs/paper.toml");
/// Configurations that come with the program, by name.
pub const PRESETS: [(&str, &str); 11] = [
    ("paper", PAPER_PRESET),
    ("fields", include_str!("../../../configs/fields.toml")),
    ("piecewise", include_str!("../../../configs/piecewise.toml")),
    ("pipelined", include_str!("../../../configs/pipelined.toml")),
    ("small", include_str!("../../../configs/small.toml")),
    ("compact", include_str!("../../../configs/compact.toml")),
    ("parity", include_str!("../../../configs/parity.toml")),
    (
        "feature-major",
        include_str!("../../../configs/feature-major.toml"),
    ),
    (
        "lean-splats",
        include_str!("../../../configs/lean-splats.toml"),
    ),
    (
        "lean-fields",
        include_str!("../../../configs/lean-fields.toml"),
    ),
    ("lean", include_str!("../../../configs/lean.toml")),
];

/// Size limit of a configuration file, in bytes.
const LIMIT: u64 = 1 << 20;

/// All parameters of the hardware.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Config {
    /// Assumed clock in GHz, a multiple of 0.001, which converts cycles to time. Left out: the clock
    /// that synthesis reaches. The paper states none. No hardware depends on it.
    ///
    /// In MHz here; `clock_ghz` in files.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clock_mhz: Option<u32>,
    /// The MVoxel that the gathering unit holds.
    pub mvoxel: MvoxelConfig,
    /// The ray index table's buffer and stream.
    pub rit: RitConfig,
    /// The gathering unit.
    pub gu: GuConfig,
    /// The vector unit.
    pub vu: VuConfig,
    /// The splat unit, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub su: Option<SuConfig>,
}

/// Why a configuration cannot be used.
#[derive(Debug, Error)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error(
        "cannot read configuration {path}: {source}; name a file, or a preset: {}",
        preset_names()
    )]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// The text is not TOML, has an unknown field, or a value of the wrong type.
    #[error("{origin}: {}{message}", place(field))]
    Parse {
        /// The file, or the preset's name.
        origin: String,
        /// Path of the field.
        field: String,
        /// The problem.
        message: String,
    },
    /// One or more rules are broken.
    #[error("{origin}: {breaches}")]
    Rules {
        /// The file, or the preset's name.
        origin: String,
        /// All broken rules.
        breaches: RuleBreaches,
    },
}

impl ConfigError {
    fn parse(origin: &str, wrong: &document::Wrong) -> Self {
        let field = match wrong.field() {
            field if field.is_empty() => WHOLE.to_owned(),
            field => field,
        };
        let place = match wrong.is_unknown_key() {
            true => places::clause(&field),
            false => String::new(),
        };
        // Its own place is surer than a key that is written like it.
        let problem = match place.is_empty() {
            true => wrong.problem(),
            false => wrong.without_suggestion(),
        };
        Self::Parse {
            origin: origin.to_owned(),
            field,
            message: format!("{problem}{place}"),
        }
    }
}

/// Name of the whole file in place of a field's path.
const WHOLE: &str = "(the file)";

/// The place of an error, for messages.
fn place(field: &str) -> String {
    match field {
        WHOLE => String::new(),
        field => format!("field `{field}`: "),
    }
}

/// Names of the presets, for messages.
fn preset_names() -> String {
    PRESETS.map(|(name, _)| name).join(", ")
}

/// A clause of a refusal: the presets that `can` do what a configuration cannot, and how to take the first
/// of them. It is empty if none can.
#[must_use]
pub fn presets_that(can: impl Fn(&Config) -> bool) -> String {
    let able = |(name, _)| Config::preset(name).filter(&can).map(|_| name);
    let names: Vec<&str> = PRESETS.into_iter().filter_map(able).collect();
    match names[..] {
        [] => String::new(),
        [only] => format!(", as the preset `{only}` has: use --config {only}"),
        [first, ..] => {
            let listed = names.join(", ");
            format!(", as the presets {listed} have: use --config {first}, or another of them")
        }
    }
}

impl Config {
    /// The preset of this name, if any.
    #[must_use]
    pub fn preset(name: &str) -> Option<Self> {
        let (_, text) = PRESETS.iter().find(|(own, _)| *own == name)?;
        Self::from_toml(text, name).ok()
    }

    /// Parses and checks a configuration; `origin` names it in errors.
    ///
    /// # Errors
    /// Text that is not TOML, unknown fields, values of the wrong type, or broken rules.
    pub fn from_toml(text: &str, origin: &str) -> Result<Self, ConfigError> {
        Ok(Self::from_bytes(text.as_bytes(), origin)?.0)
    }

    /// The configuration, and a note where it has an old key.
    fn from_bytes(bytes: &[u8], origin: &str) -> Result<(Self, Option<String>), ConfigError> {
        let document = document::toml(bytes);
        let document = document.map_err(|wrong| ConfigError::parse(origin, &wrong))?;
        Self::from_document(document, origin)
    }

    /// Makes a configuration of a document, and checks it. Returns it with a note for the user where
    /// the document has a key of the previous version.
    ///
    /// # Errors
    /// As [`Config::from_toml`].
    pub fn from_document(
        document: Value,
        origin: &str,
    ) -> Result<(Self, Option<String>), ConfigError> {
        let (config, note) = clock::in_mhz(document)
            .and_then(|(document, note)| Ok((document.read::<Self>()?, note)))
            .map_err(|wrong| ConfigError::parse(origin, &clock::in_names_of_files(wrong)))?;
        let breaches = rules::check(&config);
        if breaches.is_empty() {
            Ok((config, note))
        } else {
            Err(ConfigError::Rules {
                origin: origin.to_owned(),
                breaches,
            })
        }
    }

    /// Reads, parses and checks a configuration file.
    ///
    /// # Errors
    /// As [`Config::from_toml`], or the file cannot be read.
    pub fn read(path: &Path) -> Result<Self, ConfigError> {
        Ok(Self::read_with_note(path)?.0)
    }

    /// As [`Config::read`], with a note for the user where the file has a key of the previous
    /// version.
    ///
    /// # Errors
    /// As [`Config::read`].
    pub fn read_with_note(path: &Path) -> Result<(Self, Option<String>), ConfigError> {
        let origin = path.display().to_string();
        let (config, note) = Self::from_document(Self::document_of(path)?, &origin)?;
        Ok((config, note.map(|note| format!("{origin}: {note}"))))
    }

    /// Reads the document of a file, without a look at its keys.
    ///
    /// # Errors
    /// The file cannot be read, is larger than 1 MiB, or is not TOML.
    pub fn document_of(path: &Path) -> Result<Value, ConfigError> {
        let fail = |source| ConfigError::Read {
            path: path.to_owned(),
            source,
        };
        let bytes = crate::files::read(path, LIMIT).map_err(fail)?;
        let long = || fail(crate::file_kinds::too_long(path, LIMIT));
        let document = document::toml(&bytes.ok_or_else(long)?);
        document.map_err(|wrong| ConfigError::parse(&path.display().to_string(), &wrong))
    }

    /// The paper's configuration.
    #[must_use]
    pub fn paper() -> Self {
        Self::default()
    }

    /// A stable hash of the parameters, 12 hexadecimal digits, which identifies the hardware in
    /// headers, traces and results.
    ///
    /// It covers the parameters that differ from their defaults, by field and value, but for the
    /// assumed clock. A new parameter that a configuration does not set leaves its hash unchanged.
    #[must_use]
    pub fn hash(&self) -> String {
        identity::hash(&self.without_clock(), &Self::default())
    }

    /// The same hardware at the clock that synthesis reaches.
    #[must_use]
    pub fn without_clock(&self) -> Self {
        Self {
            clock_mhz: None,
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]
    use super::*;

    #[test]
    fn the_paper_preset_is_the_default() {
        let preset = Config::from_toml(PAPER_PRESET, "paper").unwrap();
        assert_eq!(preset, Config::default());
        assert_eq!(Config::from_toml("", "empty").unwrap(), preset);
    }

    #[test]
    fn every_field_survives_a_round_trip() {
        let config = Config::default();
        let text = config.to_toml().unwrap();
        assert_eq!(Config::from_toml(&text, "again").unwrap(), config, "{text}");
    }

    #[test]
    fn the_hash_follows_every_field() {
        let base = Config::default();
        let other = Config::from_toml("[vu.exp]\niterations = 17\n", "t").unwrap();
        assert_ne!(base.hash(), other.hash());
        assert_eq!(base.hash(), Config::default().hash());
        assert_eq!(base.hash().len(), 12);
    }

    #[test]
    fn bad_text_names_the_field() {
        for (text, field) in [
            ("[gu]\nbnks = 32\n", "gu.bnks"),
            ("[gu]\nbanks = \"many\"\n", "gu.banks"),
            ("[vu.exp]\ninput = \"3.13\"\n", "vu.exp.input"),
            ("[gu]\nvertices = [3]\n", "gu.vertices[0]"),
            ("[gu]\nvertices = [8, 8.5]\n", "gu.vertices[1]"),
            ("[gu\n", "(the file)"),
        ] {
            match Config::from_toml(text, "bad.toml").unwrap_err() {
                ConfigError::Parse { field: found, .. } => assert_eq!(found, field),
                other => panic!("{text}: {other}"),
            }
        }
    }
}
