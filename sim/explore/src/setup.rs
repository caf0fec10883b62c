//! A scene with its system: configuration, system parameters and energies.

use std::path::Path;

use potamoi_cycles::mac_array::MacArray;
use potamoi_formats::config::{Config, PRESETS};
use potamoi_scene::Scene;
use potamoi_synth::fit::Fit;
use potamoi_synth::{SynthError, SynthReport, Synthesised, UnitKind};
use potamoi_system::system_model::work::{FrameWork, PathOptions, PathReplay, PathWork, WorkCache};
use potamoi_system::system_model::{
    Area, Clock, Costs, Memory, Model, Parameters, Program, System,
};

use crate::{ExploreError, Progress};

/// A configuration.
#[derive(Debug, Clone, PartialEq)]
pub struct ConfigChoice {
    /// The configuration itself.
    pub config: Config,
    /// Name of the preset, if it is one.
    pub preset: Option<&'static str>,
}

impl ConfigChoice {
    /// The preset whose units support the scene's algorithm: `paper` or `fields`.
    ///
    /// # Errors
    /// None for the presets that come with the program.
    pub fn for_scene(scene: &Scene) -> Result<Self, ExploreError> {
        let wanted = scene.model().preset();
        let known = PRESETS.into_iter().find(|(name, _)| *name == wanted);
        let (name, text) = known.unwrap_or(PRESETS[0]);
        Ok(Self {
            config: Config::from_toml(text, &format!("preset {name}"))?,
            preset: Some(name),
        })
    }
}

/// A scene, the configuration that renders it, and the system around that.
pub struct Setup {
    /// The scene, with the camera of the frame.
    pub scene: Scene,
    /// Configuration of the units.
    pub config: Config,
    /// Name of the units' preset, if it is one.
    pub preset: Option<&'static str>,
    /// The system around the units.
    pub system: System,
    memory: Memory,
    known: UnitParameters,
    costs: Costs,
    replay: Option<PathReplay>,
}

impl Setup {
    /// A setup with the units' parameters. `synth` is a file of them, as written by `potamoi synth
    /// --json`, instead of those that come with the program. Energies and areas that no parameters
    /// have are unknown, see [`Costs::unknown`].
    ///
    /// # Errors
    /// A file that cannot be read or is of another configuration.
    pub fn new(
        chosen: ConfigChoice,
        system: &System,
        scene: Scene,
        synth: Option<&Path>,
    ) -> Result<Self, ExploreError> {
        let known = UnitParameters::read(&chosen.config, synth, system.wire_margin)?;
        let costs = known.costs(&scene, &chosen.config)?;
        Ok(Self::of(scene, chosen, system, known, costs))
    }

    fn of(
        scene: Scene,
        ConfigChoice { config, preset }: ConfigChoice,
        system: &System,
        known: UnitParameters,
        costs: Costs,
    ) -> Self {
        Self {
            scene,
            config,
            preset,
            system: system.clone(),
            // Without a cache, rates are measured in each run.
            memory: match potamoi_verilated::cache::folder("work") {
                Ok(folder) => Memory::of(system).kept_in(&folder),
                Err(_) => Memory::of(system),
            },
            known,
            costs,
            replay: None,
        }
    }

    /// Energy, area and clock of another configuration's units, in the scene's use.
    ///
    /// # Errors
    /// Parameters that lack the memories.
    pub(crate) fn costs_of(&self, scene: &Scene, config: &Config) -> Result<Costs, ExploreError> {
        self.known.costs(scene, config)
    }

    /// Energy, area and clock of the configuration's units.
    #[must_use]
    pub const fn costs(&self) -> &Costs {
        &self.costs
    }

    /// Areas of the accelerator's blocks.
    ///
    /// # Errors
    /// None for the formulas that come with the program.
    pub fn area(&self) -> Result<Area, ExploreError> {
        let (array, known) = (self.system.array(), &self.known);
        let macs = array.rows * array.columns;
        let fit = Fit::checked_in()?;
        Ok(Area::of(
            &self.config,
            &fit,
            &known.reports,
            &known.system,
            macs,
        ))
    }

    /// The work of the scene's path, and whether it was cached. Memory then uses the path's own
    /// access sequences, see [`Setup::replay`].
    ///
    /// # Errors
    /// As [`WorkCache::path`].
    pub fn count(
        &mut self,
        options: &PathOptions,
        progress: &dyn Progress,
    ) -> Result<(PathWork, bool), ExploreError> {
        progress.now(self.scene.name());
        let step = || progress.advance(1);
        let found = store()?.path(&self.scene, &self.config, options, &step)?;
        progress.now(&format!("{}: replaying memory accesses", self.scene.name()));
        self.replay(options)?;
        Ok(found)
    }

    /// Replays a path's access sequences, which memory then uses in place of general rates.
    ///
    /// # Errors
    /// As [`WorkCache::replay`].
    pub fn replay(&mut self, options: &PathOptions) -> Result<(), ExploreError> {
        let (scene, config) = (&self.scene, &self.config);
        let found = store()?.replay(scene, config, options, &self.memory)?;
        self.replay = Some(found);
        Ok(())
    }

    /// The system's memory.
    #[must_use]
    pub const fn memory(&self) -> &Memory {
        &self.memory
    }

    /// The model of the system with the configuration's units.
    #[must_use]
    pub fn model(&self) -> Model<'_> {
        self.model_of(&self.costs)
    }

    /// The model of the system with another configuration's units.
    #[must_use]
    pub(crate) fn model_of<'a>(&'a self, costs: &'a Costs) -> Model<'a> {
        Model {
            system: &self.system,
            memory: &self.memory,
            costs,
            clock_ghz: costs.clock.ghz,
            // Two bytes each.
            weight_bytes: 2 * self.scene.facts().weights as u64,
            replay: self.replay.as_ref(),
        }
    }

    /// The work of the frame that the scene's camera sees.
    ///
    /// # Errors
    /// As [`WorkCache::frame`].
    pub fn frame(&self) -> Result<FrameWork, ExploreError> {
        self.frame_of(&self.config, self.system.array())
    }

    /// The work of that frame with another configuration and array.
    ///
    /// # Errors
    /// As [`WorkCache::frame`].
    pub(crate) fn frame_of(
        &self,
        config: &Config,
        array: MacArray,
    ) -> Result<FrameWork, ExploreError> {
        let cache = self.system.gpu.cache_bytes();
        Ok(store()?.frame(&self.scene, config, array, cache)?.0)
    }
}

/// Cache of counted work between runs: the folder `work` of the program's cache.
///
/// # Errors
/// There is no folder for it.
pub fn store() -> Result<WorkCache, ExploreError> {
    let folder = potamoi_verilated::cache::folder("work").map_err(SynthError::from)?;
    Ok(WorkCache::new(&folder))
}

/// The clock of a configuration's accelerator by the parameters that come with the program.
///
/// # Errors
/// None for those parameters.
pub(crate) fn accelerator_clock(scene: &Scene, config: &Config) -> Result<Clock, ExploreError> {
    let known = UnitParameters::read(config, None, System::default().wire_margin)?;
    Ok(known.costs(scene, config)?.clock)
}

/// Known unit parameters: a given file, then those that come with the program.
struct UnitParameters {
    reports: Vec<Synthesised>,
    /// Whether the first was given.
    is_given: bool,
    records: SynthReport,
    system: SynthReport,
    wire_margin: f64,
}

impl UnitParameters {
    fn read(config: &Config, given: Option<&Path>, wire_margin: f64) -> Result<Self, ExploreError> {
        let mut reports = Synthesised::checked_in()?;
        let [system, _] = SynthReport::checked_in()?;
        if let Some(path) = given {
            let report = SynthReport::read(path)?.of(config, path)?;
            let config = config.clone();
            reports.insert(0, Synthesised { config, report });
        }
        Ok(Self {
            is_given: given.is_some(),
            reports,
            records: SynthReport::of_records()?,
            system,
            wire_margin,
        })
    }

    /// Energy, area and clock of units and memories.
    fn costs(&self, scene: &Scene, config: &Config) -> Result<Costs, ExploreError> {
        let program = match scene.model().is_splats() {
            true => Program::Splats,
            false => Program::Fields,
        };
        let given = (self.reports.iter().take(usize::from(self.is_given)))
            .find(|r| r.has(config, UnitKind::Gathering))
            .map(|r| &r.report);
        let parameters = Parameters {
            given,
            reports: &self.reports,
            records: &self.records,
            system: &self.system,
            wire_margin: self.wire_margin,
        };
        Ok(Costs::new(
            config,
            program,
            Fit::checked_in()?,
            &parameters,
        )?)
    }
}
