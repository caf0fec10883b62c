//! What the frames of a scene are modelled on: configuration, system, energy of units.

use std::path::Path;

use potamoi_formats::config::{Config, PRESETS};
use potamoi_scene::{Model as SceneModel, Scene};
use potamoi_synth::fit::Fit;
use potamoi_synth::{SynthError, SynthReport, Synthesised, UnitKind};
use potamoi_system::soc::npu::Array;
use potamoi_system::soc::work::{FrameWork, PathOptions, PathReplay, WorkCache};
use potamoi_system::soc::{Costs, Memory, Model, Program, System};

use crate::args::Common;
use crate::failure::Failure;

/// A scene, the configuration that renders it, and the system around that.
pub(crate) struct Setup {
    pub(crate) scene: Scene,
    pub(crate) config: Config,
    /// The preset whose units it is.
    pub(crate) preset: Option<&'static str>,
    pub(crate) system: System,
    memory: Memory,
    known: Known,
    costs: Costs,
    replay: Option<PathReplay>,
}

impl Setup {
    /// `synth` are parameters of the configuration's units, instead of those that come with the
    /// program.
    pub(crate) fn new(
        common: &Common,
        system: &System,
        scene: Scene,
        synth: Option<&Path>,
    ) -> Result<Self, Failure> {
        let (config, preset) = config_for(common, &scene)?;
        let known = Known::read(&config, synth)?;
        let costs = known.costs(&scene, &config)?;
        Ok(Self::of(scene, (config, preset), system, known, costs))
    }

    /// The same where energy may be unknown: [`Setup::costs`] are then the preset's, for times alone.
    pub(crate) fn of_times(
        common: &Common,
        scene: Scene,
        synth: Option<&Path>,
    ) -> Result<Self, Failure> {
        let (config, preset) = config_for(common, &scene)?;
        let known = Known::read(&config, synth)?;
        let costs = match known.costs(&scene, &config) {
            Ok(costs) => costs,
            Err(_) => known.costs(&scene, &config_for(&Common::default(), &scene)?.0)?,
        };
        let system = System::default();
        Ok(Self::of(scene, (config, preset), &system, known, costs))
    }

    fn of(
        scene: Scene,
        (config, preset): (Config, Option<&'static str>),
        system: &System,
        known: Known,
        costs: Costs,
    ) -> Self {
        Self {
            scene,
            config,
            preset,
            system: system.clone(),
            memory: Memory::lpddr3(system.memory_channels),
            known,
            costs,
            replay: None,
        }
    }

    /// Energy and area of a configuration's units as a scene uses them.
    pub(crate) fn costs_of(&self, scene: &Scene, config: &Config) -> Result<Costs, Failure> {
        self.known.costs(scene, config)
    }

    /// The same of the configuration.
    pub(crate) const fn costs(&self) -> &Costs {
        &self.costs
    }

    /// Has memory take for the frames of a path what their accesses in their order do.
    pub(crate) fn replay(&mut self, options: &PathOptions) -> Result<(), Failure> {
        let (scene, config) = (&self.scene, &self.config);
        let found = store()?.replay(scene, config, options, &self.memory)?;
        self.replay = Some(found);
        Ok(())
    }

    pub(crate) const fn memory(&self) -> &Memory {
        &self.memory
    }

    pub(crate) fn model(&self) -> Model<'_> {
        self.model_of(&self.config, &self.costs)
    }

    /// The same with units of another configuration.
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
    pub(crate) fn frame(&self) -> Result<FrameWork, Failure> {
        self.frame_of(&self.config, self.system.array())
    }

    /// The same on another accelerator.
    pub(crate) fn frame_of(&self, config: &Config, array: Array) -> Result<FrameWork, Failure> {
        let cache = self.system.gpu.cache_bytes;
        Ok(store()?.frame(&self.scene, config, array, cache)?.0)
    }
}

/// Where counted work is kept.
pub(crate) fn store() -> Result<WorkCache, Failure> {
    let folder = potamoi_verilated::cache::folder("work").map_err(SynthError::from)?;
    Ok(WorkCache::new(&folder))
}

/// The configuration that was asked for; where none was, the preset that has what the scene's
/// model needs.
pub(crate) fn config_for(
    common: &Common,
    scene: &Scene,
) -> Result<(Config, Option<&'static str>), Failure> {
    if common.config.is_some() {
        return Ok((common.read_config()?, common.preset()));
    }
    let wanted = match scene.model() {
        SceneModel::Splats(_) | SceneModel::Voxels(_) => "paper",
        _ => "fields",
    };
    let preset = PRESETS.iter().find(|(name, _)| *name == wanted);
    match preset {
        Some((name, text)) => Ok((
            Config::from_toml(text, &format!("preset {name}"))?,
            Some(*name),
        )),
        None => Ok((common.read_config()?, common.preset())),
    }
}

/// What is known of units: one file that was given, then what comes with the program.
struct Known {
    reports: Vec<Synthesised>,
    /// The first of them, where it was given.
    is_given: bool,
    records: SynthReport,
    memories: SynthReport,
}

impl Known {
    fn read(config: &Config, given: Option<&Path>) -> Result<Self, Failure> {
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
    fn costs(&self, scene: &Scene, config: &Config) -> Result<Costs, Failure> {
        let program = match scene.model() {
            SceneModel::Splats(_) | SceneModel::Compact(_) => Program::Splats,
            _ => Program::Fields,
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
