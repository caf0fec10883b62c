//! A scene with its system: configuration, system parameters and energies.

use std::path::Path;

use potamoi_cycles::mac_array::MacArray;
use potamoi_formats::config::{Config, PRESETS};
use potamoi_scene::Scene;
use potamoi_synth::fit::Fit;
use potamoi_synth::{SynthError, SynthReport, Synthesised, UnitKind};
use potamoi_system::system_model::work::{FrameWork, PathOptions, PathReplay, PathWork, WorkCache};
use potamoi_system::system_model::{Costs, Memory, Model, Program, System};

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
    /// A setup whose energies are known. `synth` is a file of unit parameters, as written by
    /// `potamoi synth --json`, instead of those that come with the program.
    ///
    /// # Errors
    /// A file that cannot be read or is of another configuration; units without known energy.
    pub fn new(
        chosen: ConfigChoice,
        system: &System,
        scene: Scene,
        synth: Option<&Path>,
    ) -> Result<Self, ExploreError> {
        let known = UnitParameters::read(&chosen.config, synth)?;
        let costs = known.costs(&scene, &chosen.config)?;
        Ok(Self::of(scene, chosen, system, known, costs))
    }

    /// A setup for times alone, in the paper's system. Where energies are not known,
    /// [`Setup::costs`] are those of the scene's preset.
    ///
    /// # Errors
    /// As [`Setup::new`] for a file.
    pub fn of_times(
        chosen: ConfigChoice,
        scene: Scene,
        synth: Option<&Path>,
    ) -> Result<Self, ExploreError> {
        let known = UnitParameters::read(&chosen.config, synth)?;
        let costs = match known.costs(&scene, &chosen.config) {
            Ok(costs) => costs,
            Err(_) => known.costs(&scene, &ConfigChoice::for_scene(&scene)?.config)?,
        };
        let system = System::default();
        Ok(Self::of(scene, chosen, &system, known, costs))
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

    /// Energy and area of another configuration's units, in the scene's use.
    ///
    /// # Errors
    /// Units without known energy.
    pub(crate) fn costs_of(&self, scene: &Scene, config: &Config) -> Result<Costs, ExploreError> {
        self.known.costs(scene, config)
    }

    /// Energy and area of the configuration's units.
    #[must_use]
    pub const fn costs(&self) -> &Costs {
        &self.costs
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
        self.model_of(&self.config, &self.costs)
    }

    /// The model of the system with another configuration's units.
    #[must_use]
    pub(crate) fn model_of<'a>(&'a self, config: &Config, costs: &'a Costs) -> Model<'a> {
        Model {
            system: &self.system,
            memory: &self.memory,
            costs,
            clock_ghz: f64::from(config.clock_mhz) * 1e-3,
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

/// Known unit parameters: a given file, then those that come with the program.
struct UnitParameters {
    reports: Vec<Synthesised>,
    /// Whether the first was given.
    is_given: bool,
    records: SynthReport,
    memories: SynthReport,
}

impl UnitParameters {
    fn read(config: &Config, given: Option<&Path>) -> Result<Self, ExploreError> {
        let checked_in = Synthesised::checked_in()?;
        let memories = checked_in[0].report.clone();
        let mut reports = checked_in.to_vec();
        if let Some(path) = given {
            let report = SynthReport::read(path)?.of(config, path)?;
            let config = config.clone();
            reports.insert(0, Synthesised { config, report });
        }
        Ok(Self {
            is_given: given.is_some(),
            reports,
            records: SynthReport::of_records()?,
            memories,
        })
    }

    /// Energy and area of units and memories.
    fn costs(&self, scene: &Scene, config: &Config) -> Result<Costs, ExploreError> {
        let program = match scene.model().is_splats() {
            true => Program::Splats,
            false => Program::Fields,
        };
        let (fit, reports) = (Fit::checked_in()?, &self.reports);
        let given = (reports.iter().take(usize::from(self.is_given)))
            .find(|r| r.has(config, UnitKind::Gathering))
            .map(|r| &r.report);
        let (records, memories) = (&self.records, &self.memories);
        let costs = Costs::new(config, program, fit, given, reports, records, memories);
        Ok(costs?)
    }
}
