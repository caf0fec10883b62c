//! What synthesis would find, without it.

use potamoi_formats::config::Config;
use potamoi_synth::fit::{EnergiesOf, Estimate, Fit, Formula, LeftOut, ScaledEstimate, Work};
use potamoi_synth::grid::Family;
use potamoi_synth::{MemoryArea, SynthError, UnitKind, macros, scaling};
use serde::Serialize;

/// The work that a unit is estimated at, and the node that it is scaled to.
#[derive(Debug, Clone, Copy, Default)]
pub struct EstimateOf<'a> {
    /// Share of the cycles in which it issues, 0 to 1; none: that of the work that the netlists were
    /// run with.
    pub busy: Option<f64>,
    /// Channels of a sample; none: those of the same work.
    pub channels: Option<u64>,
    /// Factors to another node; none: not scaled.
    pub scaled_by: Option<&'a scaling::Factors>,
}

/// What synthesis of a unit would find, without it.
#[derive(Debug, Serialize)]
pub struct UnitEstimate {
    /// Its top module.
    pub unit: &'static str,
    /// The units that the formulas are of.
    pub family: Family,
    /// Relative, at points that were left out.
    pub errors: LeftOut,
    /// The work that energies were found with; none where none were.
    pub energies_of: Option<EnergiesOf>,
    /// The figures at the node of the syntheses.
    #[serde(flatten)]
    pub estimate: Estimate,
    /// The same at another node; none where it is not scaled.
    pub scaled: Option<ScaledEstimate>,
    /// Not in any of these figures.
    pub memories: Vec<MemoryArea>,
    /// What the figures are from.
    pub formulas: Vec<Formula>,
}

impl UnitEstimate {
    /// By formulas that were fitted to syntheses.
    ///
    /// # Errors
    /// A unit that no formula is of.
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
