//! Cache of counted work, keyed by all its inputs.

use std::path::{Path, PathBuf};

use potamoi_formats::config::Config;
use potamoi_result_cache::{self as result_cache, Key};
use potamoi_scene::Scene;
use serde::Serialize;
use serde::de::DeserializeOwned;
use thiserror::Error;

use super::super::memory::Memory;
use super::frame::FrameWork;
use super::path::{PathError, PathOptions, PathWork};
use super::replay::PathReplay;
use potamoi_cycles::mac_array::MacArray;

/// Version of the counting code, raised where counts change.
const VERSION: &str = "4";

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
}

impl WorkCache {
    /// A cache in `folder`, which is created if missing.
    #[must_use]
    pub fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
        }
    }

    /// The work of a path, and whether it was cached. Work is cached for the same scene, cameras,
    /// configuration, options and program version; otherwise it is counted and stored.
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
        self.get(&path_key(scene, config, options), || {
            PathWork::count(scene, config, options, step)
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
        self.get(&frame_key(scene, config, array, cache), || {
            Ok(FrameWork::count(scene, config, array, cache, None)?)
        })
    }

    /// The memory replay of a path, cached in the same way.
    ///
    /// # Errors
    /// As [`PathReplay::of`]; a folder that cannot be written.
    pub fn replay(
        &self,
        scene: &Scene,
        config: &Config,
        options: &PathOptions,
        memory: &Memory,
    ) -> Result<PathReplay, WorkCacheError> {
        let key = replay_key(scene, config, options, memory);
        let found = self.get(&key, || PathReplay::of(scene, config, options, memory))?;
        Ok(found.0)
    }

    fn get<T: Serialize + DeserializeOwned>(
        &self,
        key: &Key,
        count: impl FnOnce() -> Result<T, PathError>,
    ) -> Result<(T, bool), WorkCacheError> {
        let path = key.file(&self.folder, "json");
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

/// Key of all that counted work depends on: the program's version, every number of the
/// configuration, and every part of the scene.
fn key(kind: &str, scene: &Scene, config: &Config) -> Key {
    let key = Key::new(kind, VERSION).value("configuration", config);
    (scene.identity().into_iter()).fold(key, |key, (part, hash)| key.hash(part, hash))
}

fn path_key(scene: &Scene, config: &Config, options: &PathOptions) -> Key {
    key("path", scene, config).value("path", options)
}

fn replay_key(scene: &Scene, config: &Config, options: &PathOptions, memory: &Memory) -> Key {
    key("replay", scene, config)
        .value("path", options)
        .hash("memory", memory.identity())
}

fn frame_key(scene: &Scene, config: &Config, array: MacArray, cache: u32) -> Key {
    // A new field has to be a part.
    let MacArray {
        rows,
        columns,
        dataflow,
        is_double_buffered,
    } = array;
    key("frame", scene, config)
        .value("rows", &rows)
        .value("columns", &columns)
        .value("dataflow", &dataflow)
        .value("is_double_buffered", &is_double_buffered)
        .value("cache", &cache)
}

#[cfg(test)]
mod tests;
