//! Parameters with the configuration that they are of: of presets, which come with the program, and of files.

use std::path::Path;

use potamoi_formats::config::Config;

use super::{FIELDS, PAPER, REMEDY};
use crate::grid::is_same_unit;
use crate::{SynthError, SynthReport, UnitKind};

/// Parameters with their configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct Synthesised {
    /// The configuration.
    pub config: Config,
    /// Parameters of its units.
    pub report: SynthReport,
}

/// Presets that were synthesised, with what `potamoi synth --json` wrote: one line each.
const PRESETS_SYNTHESISED: [(&str, &str); 11] = [
    ("paper", PAPER),
    ("fields", FIELDS),
    (
        "piecewise",
        include_str!("../../../../synth/piecewise-asap7.json"),
    ),
    (
        "pipelined",
        include_str!("../../../../synth/pipelined-asap7.json"),
    ),
    ("small", include_str!("../../../../synth/small-asap7.json")),
    (
        "compact",
        include_str!("../../../../synth/compact-asap7.json"),
    ),
    (
        "parity",
        include_str!("../../../../synth/parity-asap7.json"),
    ),
    (
        "feature-major",
        include_str!("../../../../synth/feature-major-asap7.json"),
    ),
    (
        "lean-splats",
        include_str!("../../../../synth/lean-splats-asap7.json"),
    ),
    (
        "lean-fields",
        include_str!("../../../../synth/lean-fields-asap7.json"),
    ),
    ("lean", include_str!("../../../../synth/lean-asap7.json")),
];

impl Synthesised {
    /// Parameters of the synthesised presets that come with the program, in ASAP7 at 7 nm.
    ///
    /// # Errors
    /// As [`SynthReport::checked_in`].
    pub fn checked_in() -> Result<Vec<Self>, SynthError> {
        let of = |(name, text): &(&str, &str)| -> Result<Self, SynthError> {
            let path = format!("synth/{name}-asap7.json");
            let fail = |why: String| SynthError::Parameters {
                path: path.clone().into(),
                why,
                remedy: REMEDY,
            };
            let report = SynthReport::parse(text).map_err(fail)?;
            let unknown = || fail(format!("{name} is no preset"));
            let config = Config::preset(name).ok_or_else(unknown)?;
            let report = report.of(&config, path.as_ref())?;
            Ok(Self { config, report })
        };
        PRESETS_SYNTHESISED.iter().map(of).collect()
    }

    /// Reads a file that `potamoi synth --json` wrote, with the configuration that stands in it.
    ///
    /// # Errors
    /// As [`SynthReport::read`]; it names no configuration, or another one than its hash is of.
    pub fn read(path: &Path) -> Result<Self, SynthError> {
        let report = SynthReport::read(path)?;
        let fail = |why: String| SynthError::Parameters {
            path: path.to_owned(),
            why,
            remedy: REMEDY,
        };
        let text = report.configuration_toml.as_deref();
        let text = text.ok_or_else(|| fail("`configuration_toml` is missing".to_owned()))?;
        let config = Config::from_toml(text, "configuration_toml");
        let config = config.map_err(|error| fail(error.to_string()))?;
        let report = report.of(&config, path)?;
        Ok(Self { config, report })
    }

    /// Whether a unit of a configuration was synthesised here.
    #[must_use]
    pub fn has(&self, config: &Config, unit: UnitKind) -> bool {
        self.report.unit(unit).is_some() && is_same_unit(&self.config, config, unit)
    }
}
