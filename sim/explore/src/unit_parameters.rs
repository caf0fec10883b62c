//! Parameters of units: a given file, and those that come with the program.

use std::path::Path;
use std::sync::{Arc, OnceLock};

use potamoi_formats::config::Config;
use potamoi_scene::Scene;
use potamoi_synth::fit::Fit;
use potamoi_synth::{SynthReport, Synthesised, UnitKind};
use potamoi_system::system_model::{Area, Costs, OnChipSizes, Parameters, Program};

use crate::ExploreError;

/// Unit parameters and formulas that come with the program.
pub(crate) struct CheckedIn {
    pub(crate) reports: Vec<Synthesised>,
    records: SynthReport,
    system: SynthReport,
    fit: Arc<Fit>,
}

/// They are read once.
pub(crate) fn checked_in() -> Result<&'static CheckedIn, ExploreError> {
    static READ: OnceLock<CheckedIn> = OnceLock::new();
    if let Some(known) = READ.get() {
        return Ok(known);
    }
    let [system, _] = SynthReport::checked_in()?;
    let read = CheckedIn {
        reports: Synthesised::checked_in()?,
        records: SynthReport::of_records()?,
        system,
        fit: Arc::new(Fit::checked_in()?),
    };
    Ok(READ.get_or_init(|| read))
}

/// Known unit parameters: a given file, then those that come with the program.
pub(crate) struct UnitParameters {
    given: Option<Vec<Synthesised>>,
    known: &'static CheckedIn,
    wire_margin: f64,
}

impl UnitParameters {
    pub(crate) fn checked_in(wire_margin: f64) -> Result<Self, ExploreError> {
        Ok(Self {
            given: None,
            known: checked_in()?,
            wire_margin,
        })
    }

    pub(crate) fn read(
        config: &Config,
        given: Option<&Path>,
        wire_margin: f64,
    ) -> Result<Self, ExploreError> {
        let mut own = Self::checked_in(wire_margin)?;
        if let Some(path) = given {
            let report = SynthReport::read(path)?.of(config, path)?;
            let config = config.clone();
            let mut all = own.known.reports.clone();
            all.insert(0, Synthesised { config, report });
            own.given = Some(all);
        }
        Ok(own)
    }

    fn reports(&self) -> &[Synthesised] {
        self.given.as_deref().unwrap_or(&self.known.reports)
    }

    /// Areas of the accelerator's blocks.
    pub(crate) fn area(&self, config: &Config, sizes: &OnChipSizes) -> Result<Area, ExploreError> {
        let known = self.known;
        Ok(Area::of(
            config,
            &known.fit,
            self.reports(),
            &known.system,
            sizes,
        ))
    }

    /// Energy, area and clock of units and memories.
    pub(crate) fn costs(
        &self,
        scene: &Scene,
        config: &Config,
        sizes: &OnChipSizes,
    ) -> Result<Costs, ExploreError> {
        self.costs_by(scene, config, sizes, &[])
    }

    /// As [`UnitParameters::costs`], without the syntheses of the kinds in `estimated`.
    pub(crate) fn costs_by(
        &self,
        scene: &Scene,
        config: &Config,
        sizes: &OnChipSizes,
        estimated: &[UnitKind],
    ) -> Result<Costs, ExploreError> {
        let program = match scene.model().is_splats() {
            true => Program::Splats,
            false => Program::Fields,
        };
        let given = (self.reports().iter().take(self.given.iter().len()))
            .find(|r| r.has(config, UnitKind::Gathering))
            .filter(|_| !estimated.contains(&UnitKind::Gathering))
            .map(|r| &r.report);
        let parameters = Parameters {
            given,
            estimated,
            reports: self.reports(),
            records: &self.known.records,
            system: &self.known.system,
            sizes: *sizes,
            wire_margin: self.wire_margin,
        };
        Ok(Costs::new(
            config,
            program,
            Arc::clone(&self.known.fit),
            &parameters,
        )?)
    }
}
