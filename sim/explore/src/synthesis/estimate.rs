//! Estimates of synthesis results by fitted formulas.

use potamoi_formats::config::Config;
use potamoi_synth::fit::{EnergiesOf, Estimate, Fit, Formula, LeftOut, ScaledEstimate, Work};
use potamoi_synth::grid::Family;
use potamoi_synth::{MemoryArea, SynthError, UnitKind, macros, scaling};
use schemars::JsonSchema;
use serde::Serialize;

/// Operating point and target node of an estimate.
#[derive(Debug, Clone, Copy, Default)]
pub struct EstimateOf<'a> {
    /// Share of cycles in which the unit issues, 0 to 1; `None`: that of the netlists' work.
    pub busy: Option<f64>,
    /// Channels of a sample; `None`: that of the netlists' work.
    pub channels: Option<u64>,
    /// Scaling factors to another node; `None`: not scaled.
    pub scaled_by: Option<&'a scaling::Factors>,
}

/// Estimated synthesis results of a unit.
#[derive(Debug, Serialize, JsonSchema)]
pub struct UnitEstimate {
    /// Name of its top module.
    pub unit: &'static str,
    /// Units that the formulas cover.
    pub family: Family,
    /// Relative errors at points left out of the fit.
    pub errors: LeftOut,
    /// Work that energies are for; `None` without energies.
    pub energies_of: Option<EnergiesOf>,
    /// Estimate at the node of the syntheses.
    #[serde(flatten)]
    pub estimate: Estimate,
    /// Estimate at another node; `None` if not scaled.
    pub scaled: Option<ScaledEstimate>,
    /// Memories, which no figure includes.
    pub memories: Vec<MemoryArea>,
    /// Formulas behind the figures.
    pub formulas: Vec<Formula>,
}

impl UnitEstimate {
    /// Estimates a unit by formulas fitted to syntheses.
    ///
    /// # Errors
    /// A unit that no formula covers.
    pub fn new(
        fit: &Fit,
        config: &Config,
        unit: UnitKind,
        of: &EstimateOf<'_>,
    ) -> Result<Self, SynthError> {
        let family = fit.family(config, unit)?;
        let usual = fit.usual_work(family, config);
        let work = Work {
            busy: of.busy.unwrap_or(usual.busy),
            channels: of.channels.unwrap_or(usual.channels),
        };
        let estimate = fit.estimate(config, unit, work)?;
        Ok(Self {
            unit: unit.top(),
            family,
            errors: fit.left_out(family)?,
            energies_of: fit.energies_of(family),
            scaled: of.scaled_by.map(|factors| estimate.scaled(factors)),
            estimate,
            memories: macros(config, unit)?,
            formulas: fit.formulas(family),
        })
    }
}
