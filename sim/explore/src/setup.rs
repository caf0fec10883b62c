//! A scene with its system: configuration, system parameters and energies.

use std::collections::HashMap;
use std::path::Path;
use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use potamoi_cycles::mac_array::MacArray;
use potamoi_formats::config::{Config, PRESETS};
use potamoi_scene::Scene;
use potamoi_synth::{SynthError, UnitKind, scaling};
use potamoi_system::system_model::work::{FrameWork, PathOptions, PathReplay, PathWork, WorkCache};
use potamoi_system::system_model::{Area, Clock, Costs, Memory, Model, OnChipSizes, System};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::syntheses::Syntheses;
use crate::unit_parameters::{UnitParameters, checked_in};
use crate::{ExploreError, Progress};

/// Node of areas in nanometres, that of the system.
const NODE_NM: u32 = 12;

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

/// Results that several setups share: counted work, rates of memories, and costs of configurations.
/// Each is found once.
#[derive(Default)]
pub struct Shared {
    store: OnceLock<WorkCache>,
    memories: Mutex<HashMap<blake3::Hash, Arc<Memory>>>,
    costs: Mutex<HashMap<String, Priced>>,
}

/// Costs of a configuration and areas of the accelerator.
type Priced = (Arc<Costs>, Arc<Area>);

impl Shared {
    fn store(&self) -> Result<WorkCache, ExploreError> {
        if let Some(own) = self.store.get() {
            return Ok(own.clone());
        }
        let own = store()?.held_in_memory();
        Ok(self.store.get_or_init(|| own).clone())
    }

    fn memory(&self, system: &System) -> Arc<Memory> {
        let own = memory_of(system);
        let mut all = self.memories.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(all.entry(own.identity()).or_insert_with(|| Arc::new(own)))
    }

    /// Costs and areas of a key, which names all that they depend on.
    fn priced(
        &self,
        key: String,
        find: impl FnOnce() -> Result<Priced, ExploreError>,
    ) -> Result<Priced, ExploreError> {
        let known = |all: &HashMap<String, Priced>| all.get(&key).cloned();
        let lock = || self.costs.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known(&lock()) {
            return Ok(found);
        }
        // Threads that find the same find equal ones.
        let found = find()?;
        Ok(lock().entry(key).or_insert(found).clone())
    }
}

/// Refuses a feature buffer that has no room for a scene's reorder buffer beside two blocks.
fn check_room(scene: &Scene, system: &System) -> Result<(), ExploreError> {
    let records = scene.reorder_bytes();
    let least = records + 2 * u64::from(system.feature_block_bytes);
    match system.feature_buffer_bytes >= least {
        true => Ok(()),
        false => Err(ExploreError::Refused(format!(
            "scene {}: `system.feature_buffer_bytes` is {}: expected {least} or more, for two blocks and the \
             {records} bytes of records that wait for their turn in depth order; or render.order = \
             \"approximate\"",
            scene.name(),
            system.feature_buffer_bytes
        ))),
    }
}

/// The memory of a system, with rates kept between runs; without a cache they are measured in each.
fn memory_of(system: &System) -> Memory {
    match potamoi_verilated::cache::folder("work") {
        Ok(folder) => Memory::of(system).kept_in(&folder),
        Err(_) => Memory::of(system),
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
    memory: Arc<Memory>,
    known: Arc<UnitParameters>,
    costs: Arc<Costs>,
    area: Arc<Area>,
    store: Option<WorkCache>,
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
        check_room(&scene, system)?;
        let known = Arc::new(UnitParameters::read(
            &chosen.config,
            synth,
            system.wire_margin,
        )?);
        let sizes = OnChipSizes::from(system);
        let costs = Arc::new(known.costs(&scene, &chosen.config, &sizes)?);
        let area = Arc::new(known.area(&chosen.config, &sizes)?);
        Ok(Self {
            scene,
            config: chosen.config,
            preset: chosen.preset,
            system: system.clone(),
            memory: Arc::new(memory_of(system)),
            known,
            costs,
            area,
            store: None,
            replay: None,
        })
    }

    /// As [`Setup::new`] with these syntheses and those that come with the program; what other setups found
    /// is not found again.
    ///
    /// # Errors
    /// There is no folder for counted work.
    pub fn sharing(
        chosen: ConfigChoice,
        system: &System,
        scene: Scene,
        syntheses: &Syntheses,
        shared: &Shared,
    ) -> Result<Self, ExploreError> {
        check_room(&scene, system)?;
        let known = UnitParameters::given(syntheses.all(), system.wire_margin)?;
        let sizes = OnChipSizes::from(system);
        // Prices are the same at every clock.
        let unclocked = chosen.config.without_clock();
        let key = format!(
            "{} {} {sizes:?} {:?} {:?}",
            unclocked.hash(),
            scene.model().is_splats(),
            system.wire_margin,
            syntheses.identity(),
        );
        let (costs, area) = shared.priced(key, || {
            Ok((
                Arc::new(known.costs(&scene, &unclocked, &sizes)?),
                Arc::new(known.area(&unclocked, &sizes)?),
            ))
        })?;
        let costs = match chosen.config.clock_mhz {
            Some(_) => Arc::new(costs.at_clock_of(&chosen.config)),
            None => costs,
        };
        Ok(Self {
            scene,
            config: chosen.config,
            preset: chosen.preset,
            system: system.clone(),
            memory: shared.memory(system),
            known: Arc::new(known),
            costs,
            area,
            store: Some(shared.store()?),
            replay: None,
        })
    }

    /// Energy, area and clock of another configuration's units, in the scene's use. Units of the kinds in
    /// `estimated` are by formulas, also where they were synthesised.
    ///
    /// # Errors
    /// Parameters that lack the memories.
    pub(crate) fn costs_of(
        &self,
        (scene, config): (&Scene, &Config),
        estimated: &[UnitKind],
    ) -> Result<Costs, ExploreError> {
        self.known
            .costs_by(scene, config, &OnChipSizes::from(&self.system), estimated)
    }

    /// Energy, area and clock of the configuration's units.
    #[must_use]
    pub fn costs(&self) -> &Costs {
        &self.costs
    }

    /// Areas of the accelerator's blocks.
    #[must_use]
    pub fn area(&self) -> &Area {
        &self.area
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
        let found = self
            .store()?
            .path(&self.scene, &self.config, options, &step)?;
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
        let found = self.store()?.replay(scene, config, options, &self.memory)?;
        self.replay = Some(found);
        Ok(())
    }

    /// Another result of the frame, kept as counted work is; see [`WorkCache::of_frame`].
    ///
    /// # Errors
    /// Those of `find`; a folder that cannot be written.
    pub fn of_frame<T>(
        &self,
        kind: &str,
        parts: &[(&'static str, blake3::Hash)],
        find: impl FnOnce() -> Result<T, ExploreError>,
    ) -> Result<Arc<T>, ExploreError>
    where
        T: Serialize + DeserializeOwned + Send + Sync + 'static,
    {
        let of = (&self.scene, &self.config);
        self.store()?.of_frame(kind, of, parts, find)
    }

    /// Names of the files in the folder for counted work that [`Setup::count`] reads or writes.
    #[must_use]
    pub fn files_of_count(&self, options: &PathOptions) -> Vec<String> {
        WorkCache::files_of_path(&self.scene, &self.config, options, &self.memory)
    }

    /// Name of the file that [`Setup::of_frame`] reads or writes.
    #[must_use]
    pub fn file_of_frame(&self, kind: &str, parts: &[(&'static str, blake3::Hash)]) -> String {
        WorkCache::file_of_frame(kind, (&self.scene, &self.config), parts)
    }

    fn store(&self) -> Result<WorkCache, ExploreError> {
        self.store.clone().map_or_else(store, Ok)
    }

    /// The system's memory.
    #[must_use]
    pub fn memory(&self) -> &Memory {
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
        Ok(self.store()?.frame(&self.scene, config, array, cache)?.0)
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

/// Energy, area and clock of a configuration's units in a scene's use, and the areas of the default
/// system's blocks, by the parameters that come with the program.
///
/// # Errors
/// None for those parameters.
pub(crate) fn costs_and_area(
    scene: &Scene,
    config: &Config,
) -> Result<(Costs, Area), ExploreError> {
    let known = UnitParameters::checked_in(System::default().wire_margin)?;
    let sizes = OnChipSizes::default();
    Ok((
        known.costs(scene, config, &sizes)?,
        known.area(config, &sizes)?,
    ))
}

/// Area of all instances of a module of a synthesised unit, in square millimetres at 12 nm without
/// wires, and their number; `None` where the unit was not synthesised or has no such module.
pub(crate) fn module_area(config: &Config, unit: UnitKind, module: &str) -> Option<(f64, u64)> {
    let reports = &checked_in().ok()?.reports;
    let report = &reports.iter().find(|own| own.has(config, unit))?.report;
    let factors = scaling::logic(report.library.node_nm?, NODE_NM)?;
    let modules = &report.unit(unit)?.modules;
    let own = modules.iter().find(|own| own.module == module)?;
    let mm2 = own.count as f64 * own.area_um2 * factors.area * 1e-6;
    Some((mm2, own.count))
}

/// The clock of a configuration's accelerator by the parameters that come with the program.
///
/// # Errors
/// None for those parameters.
pub(crate) fn accelerator_clock(scene: &Scene, config: &Config) -> Result<Clock, ExploreError> {
    let known = UnitParameters::read(config, None, System::default().wire_margin)?;
    Ok(known.costs(scene, config, &OnChipSizes::default())?.clock)
}
