//! Parameters of presets that come with the program.

use potamoi_formats::config::{Config, PRESETS};

use super::REMEDY;
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

impl Synthesised {
    /// Parameters of the presets `paper` and `fields` that come with the program.
    ///
    /// # Errors
    /// As [`SynthReport::checked_in`].
    pub fn checked_in() -> Result<[Self; 2], SynthError> {
        let [paper, fields] = SynthReport::checked_in()?;
        let of = |name: &str, report| -> Result<Self, SynthError> {
            let (_, text) = PRESETS
                .iter()
                .find(|(own, _)| *own == name)
                .unwrap_or(&PRESETS[0]);
            let config = Config::from_toml(text, name).map_err(|e| SynthError::Parameters {
                path: name.into(),
                why: e.to_string(),
                remedy: REMEDY,
            })?;
            Ok(Self { config, report })
        };
        Ok([of("paper", paper)?, of("fields", fields)?])
    }

    /// Whether a unit of a configuration equals the synthesised one.
    #[must_use]
    pub fn has(&self, config: &Config, unit: UnitKind) -> bool {
        is_same_unit(&self.config, config, unit)
    }
}
