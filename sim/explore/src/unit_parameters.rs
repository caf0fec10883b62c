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
    /// All reports, of which so many are given; `None` where none is.
    given: Option<(Vec<Synthesised>, usize)>,
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

    /// With the syntheses that a user gives, before those that come with the program.
    pub(crate) fn given(given: &[Synthesised], wire_margin: f64) -> Result<Self, ExploreError> {
        let mut own = Self::checked_in(wire_margin)?;
        if !given.is_empty() {
            let all = [given, &own.known.reports].concat();
            own.given = Some((all, given.len()));
        }
        Ok(own)
    }

    pub(crate) fn read(
        config: &Config,
        given: Option<&Path>,
        wire_margin: f64,
    ) -> Result<Self, ExploreError> {
        let Some(path) = given else {
            return Self::checked_in(wire_margin);
        };
        let report = SynthReport::read(path)?.of(config, path)?;
        let config = config.clone();
        Self::given(&[Synthesised { config, report }], wire_margin)
    }

    fn reports(&self) -> &[Synthesised] {
        let given = self.given.as_ref().map(|(all, _)| all);
        given.unwrap_or(&self.known.reports)
    }

    /// The reports that are given.
    fn own(&self) -> &[Synthesised] {
        let given = self.given.as_ref();
        given.map_or(&[], |(all, count)| &all[..*count])
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
        let given = (self.own().iter())
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
