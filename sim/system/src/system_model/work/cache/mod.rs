//! Cache of counted work, keyed by all its inputs.

mod held;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use potamoi_formats::config::{Config, RitPairs};
use potamoi_result_cache::{self as result_cache, Key};
use potamoi_scene::{Scene, SceneError};
use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

use self::held::Held;
use super::super::memory::Memory;
use super::frame::{FrameEvents, FrameWork, Reads};
use super::path::{PathError, PathOptions, PathWork};
use super::path_events::PathEvents;
use super::path_pictures::PathPictures;
use super::path_reads::PathReads;
use super::replay::{PathLoads, PathReplay};
use potamoi_cycles::batch::Pricing;
use potamoi_cycles::mac_array::MacArray;

/// Version of the counting code, raised where counts change.
const VERSION: &str = "8";

/// Why work could be neither counted nor read.
#[derive(Debug, Error)]
pub enum WorkCacheError {
    /// It cannot be counted.
    #[error(transparent)]
    Path(#[from] PathError),
    /// It cannot be written.
    #[error(
        "cannot write {path}: {source}; make room (`potamoi cache --clear` removes what is kept), \
         or name another folder in POTAMOI_CACHE"
    )]
    Write {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
}

/// Cache of counted work, a folder of files.
#[derive(Debug, Clone)]
pub struct WorkCache {
    folder: PathBuf,
    held: Option<Held>,
}

impl WorkCache {
    /// A cache in `folder`, which is created if missing.
    #[must_use]
    pub fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
            held: None,
        }
    }

    /// The same cache, whose results also stay in memory, shared by its clones. Threads that ask for
    /// the same result at the same time count it once.
    #[must_use]
    pub fn held_in_memory(self) -> Self {
        Self {
            held: Some(Held::default()),
            ..self
        }
    }

    /// The work of a path, and whether its events were cached: nothing was rendered then.
    ///
    /// Pictures in floating point are cached for the same scene and path, whatever the configuration: what
    /// is rendered of warped frames, and the quality of all. Events are cached for the same scene, cameras,
    /// rendering, schedule and program version. Lanes
    /// and pipeline of the vector unit, the array, the GPU and the clock are no part of them: those
    /// are applied to cached events. Reads are cached for the same cache of the GPU.
    ///
    /// # Errors
    /// As [`PathWork::count`]; a folder that cannot be written.
    pub fn path(
        &self,
        scene: &Scene,
        config: &Config,
        options: &PathOptions,
        step: &(dyn Fn() + Sync),
    ) -> Result<(PathWork, bool), WorkCacheError> {
        let (events, was_cached) = self.events(scene, config, options, step)?;
        let key = reads_key(scene, config, options);
        let count = || Ok(PathReads::count(scene, config, options, &events, step)?);
        let (reads, _) = self.get::<_, WorkCacheError>(&key, count)?;
        Ok((events.priced(config, options, &reads)?, was_cached))
    }

    fn events(
        &self,
        scene: &Scene,
        config: &Config,
        options: &PathOptions,
        step: &(dyn Fn() + Sync),
    ) -> Result<(Arc<PathEvents>, bool), WorkCacheError> {
        self.get(&events_key(scene, config, options), || {
            PathEvents::check(scene, config)?;
            let render = || Ok(PathPictures::render(scene, options, step)?);
            let key = pictures_key(scene, options);
            let (pictures, _) = self.get::<_, WorkCacheError>(&key, render)?;
            let counted = PathEvents::count(scene, config, options, &pictures, step);
            Ok(counted?)
        })
    }

    /// The work of the frame that the scene's camera sees, cached in the same way.
    ///
    /// # Errors
    /// As [`FrameWork::count`]; a folder that cannot be written.
    pub fn frame(
        &self,
        scene: &Scene,
        config: &Config,
        array: MacArray,
        cache: u32,
    ) -> Result<(FrameWork, bool), WorkCacheError> {
        let (events, was_cached) = self
            .get::<_, WorkCacheError>(&frame_key(scene, config), || {
                Ok(FrameEvents::of(scene, config, None).map_err(PathError::from)?)
            })?;
        let (reads, _) = self
            .get::<_, WorkCacheError>(&frame_reads_key(scene, config, cache), || {
                Ok(Reads::of(scene, config, cache, None).map_err(PathError::from)?)
            })?;
        let pricing = Pricing::new(config, array);
        let pricing = pricing.map_err(|error| SceneError::of_unit(error.into()));
        let pricing = pricing.map_err(PathError::from)?;
        Ok((events.priced(&pricing, *reads), was_cached))
    }

    /// Any other result of a frame that depends on the scene, on the configuration as events do, and on
    /// `parts`; `kind` names it. It is cached in the same way.
    ///
    /// # Errors
    /// Those of `find`; a folder that cannot be written.
    pub fn of_frame<T, E>(
        &self,
        kind: &str,
        (scene, config): (&Scene, &Config),
        parts: &[(&'static str, blake3::Hash)],
        find: impl FnOnce() -> Result<T, E>,
    ) -> Result<Arc<T>, E>
    where
        T: Serialize + DeserializeOwned + Send + Sync + 'static,
        E: From<WorkCacheError>,
    {
        Ok(self
            .get(&frame_result_key(kind, (scene, config), parts), find)?
            .0)
    }

    /// The memory replay of a path. Loads are cached as events are, replays for the same memory and
    /// cache of the GPU.
    ///
    /// # Errors
    /// As [`PathWork::count`]; a folder that cannot be written.
    pub fn replay(
        &self,
        scene: &Scene,
        config: &Config,
        options: &PathOptions,
        memory: &Memory,
    ) -> Result<PathReplay, WorkCacheError> {
        let key = replay_key(scene, config, options, memory);
        let replay = || {
            let (events, _) = self.events(scene, config, options, &|| ())?;
            let burst = memory.burst_bytes();
            let (loads, _) = self
                .get::<_, WorkCacheError>(&loads_key(scene, config, options, burst), || {
                    Ok(PathLoads::of(scene, config, options, (&events, burst))?)
                })?;
            let replay = PathReplay::of(scene, config, options, memory, (&events, &loads));
            Ok::<_, WorkCacheError>(replay?)
        };
        Ok(*self.get(&key, replay)?.0)
    }

    /// Names of the files that the work of a path and its replay are kept in.
    #[must_use]
    pub fn files_of_path(
        scene: &Scene,
        config: &Config,
        options: &PathOptions,
        memory: &Memory,
    ) -> Vec<String> {
        let keys = [
            pictures_key(scene, options),
            events_key(scene, config, options),
            reads_key(scene, config, options),
            loads_key(scene, config, options, memory.burst_bytes()),
            replay_key(scene, config, options, memory),
        ];
        keys.iter().map(file_name).collect()
    }

    /// Name of the file that a result of a frame is kept in, see [`WorkCache::of_frame`].
    #[must_use]
    pub fn file_of_frame(
        kind: &str,
        of: (&Scene, &Config),
        parts: &[(&'static str, blake3::Hash)],
    ) -> String {
        file_name(&frame_result_key(kind, of, parts))
    }

    /// A result, and whether it was cached; otherwise it is counted.
    fn get<T, E>(
        &self,
        key: &Key,
        count: impl FnOnce() -> Result<T, E>,
    ) -> Result<(Arc<T>, bool), E>
    where
        T: Serialize + DeserializeOwned + Send + Sync + 'static,
        E: From<WorkCacheError>,
    {
        match &self.held {
            None => {
                let (found, was_cached) = self.file(key, count)?;
                Ok((Arc::new(found), was_cached))
            }
            Some(held) => held.get(key, || self.file(key, count)),
        }
    }

    /// As [`WorkCache::get`], from the folder alone.
    fn file<T, E>(&self, key: &Key, count: impl FnOnce() -> Result<T, E>) -> Result<(T, bool), E>
    where
        T: Serialize + DeserializeOwned,
        E: From<WorkCacheError>,
    {
        let path = self.folder.join(file_name(key));
        if let Some(work) = result_cache::read(&path) {
            return Ok((work, true));
        }
        let work = count()?;
        let fail = |source| WorkCacheError::Write {
            path: path.clone(),
            source,
        };
        std::fs::create_dir_all(&self.folder).map_err(fail)?;
        result_cache::write(&path, &work).map_err(fail)?;
        Ok((work, false))
    }
}

/// Name of the file of a key.
fn file_name(key: &Key) -> String {
    key.file(Path::new(""), "json").display().to_string()
}

fn frame_result_key(
    kind: &str,
    (scene, config): (&Scene, &Config),
    parts: &[(&'static str, blake3::Hash)],
) -> Key {
    let own = key(kind, scene, config);
    parts
        .iter()
        .fold(own, |key, (part, hash)| key.hash(part, *hash))
}

/// The configuration as far as rendering and schedule depend on it, in a fixed form. The clock is in
/// neither, nor are lanes and pipeline of a vector unit whose lengths do not depend on operands. The
/// cycles of a splat unit depend on the exponential.
fn scheduled(config: &Config) -> Config {
    let mut own = config.without_clock();
    if !own.vu.exp.early_out && own.su.is_none() {
        let paper = Config::paper();
        own.vu.lanes = paper.vu.lanes;
        own.vu.exp.pipelined = paper.vu.exp.pipelined;
        own.vu.exp.iterations_per_clock = paper.vu.exp.iterations_per_clock;
    }
    own
}

/// Key of all that events depend on: the program's version, the configuration as far as it matters,
/// and every part of the scene.
fn key(kind: &str, scene: &Scene, config: &Config) -> Key {
    of_scene(kind, scene).value("configuration", &scheduled(config))
}

fn of_scene(kind: &str, scene: &Scene) -> Key {
    let key = Key::new(kind, VERSION);
    (scene.identity().into_iter()).fold(key, |key, (part, hash)| key.hash(part, hash))
}

/// The options that a path is rendered with: array and cache come later.
fn rendered(options: &PathOptions) -> PathOptions {
    PathOptions {
        array: [0, 0],
        is_double_buffered: false,
        cache: 0,
        ..*options
    }
}

/// Key of pictures in floating point, which depend on no configuration.
fn pictures_key(scene: &Scene, options: &PathOptions) -> Key {
    of_scene("pictures", scene).value("path", &rendered(options))
}

fn events_key(scene: &Scene, config: &Config, options: &PathOptions) -> Key {
    key("path", scene, config).value("path", &rendered(options))
}

/// Key of reads. Of the configuration they depend on which pairs are listed; which pixels of targets are
/// rendered does not depend on it.
fn of_reads(kind: &str, scene: &Scene, config: &Config) -> Key {
    let key = of_scene(kind, scene);
    match config.rit.pairs {
        RitPairs::All => key,
        RitPairs::ThatMayCount => {
            let opacity = config.su.as_ref().map(|su| su.opacity);
            let key = key.value("pairs that may count", &scheduled(config).vu.exp);
            key.value("opacity", &opacity)
        }
    }
}

fn reads_key(scene: &Scene, config: &Config, options: &PathOptions) -> Key {
    let path = of_reads("reads", scene, config).value("path", &rendered(options));
    path.value("cache", &options.cache)
}

fn loads_key(scene: &Scene, config: &Config, options: &PathOptions, burst: u64) -> Key {
    let path = key("loads", scene, config).value("path", &rendered(options));
    path.value("burst", &burst)
}

fn replay_key(scene: &Scene, config: &Config, options: &PathOptions, memory: &Memory) -> Key {
    key("replay", scene, config)
        .value("path", &rendered(options))
        .value("cache", &options.cache)
        .hash("memory", memory.identity())
}

fn frame_key(scene: &Scene, config: &Config) -> Key {
    key("frame", scene, config)
}

fn frame_reads_key(scene: &Scene, config: &Config, cache: u32) -> Key {
    of_reads("frame-reads", scene, config).value("cache", &cache)
}

#[cfg(test)]
mod tests;
