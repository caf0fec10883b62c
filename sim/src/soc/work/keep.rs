//! Work that was counted is kept, by what it was counted of.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use potamoi_formats::config::Config;
use potamoi_golden::effects::Choices;
use potamoi_golden::scene::Scene;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use thiserror::Error;

use super::super::memory::Memory;
use super::super::npu::Array;
use super::frame::FrameWork;
use super::path::{PathError, PathOptions, PathWork};
use super::replay::PathReplay;

/// Raised where what is counted changes.
const VERSION: u32 = 3;

/// Work that could neither be counted nor read.
#[derive(Debug, Error)]
pub enum KeepError {
    /// It cannot be counted.
    #[error(transparent)]
    Path(#[from] PathError),
    /// It cannot be written.
    #[error("cannot write {path}: {source}; name another folder in POTAMOI_CACHE")]
    Write {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

/// What work is of.
#[derive(Serialize)]
struct Key<'a, O> {
    version: u32,
    program: &'static str,
    kind: &'static str,
    configuration: String,
    scene: &'a str,
    camera: String,
    merges: bool,
    #[serde(skip_serializing_if = "super::is_default")]
    halvings: u32,
    /// Effects that are forced or left out, and whether frames that stand still count as their
    /// reference: what was counted before is of neither.
    #[serde(skip_serializing_if = "Option::is_none")]
    choices: Option<String>,
    /// How it is rendered, where that is not as its name says.
    #[serde(skip_serializing_if = "Option::is_none")]
    manner: Option<String>,
    options: O,
    /// Of a model that its name does not say all of: its numbers.
    model: Option<String>,
}

/// Where work is kept.
#[derive(Debug, Clone)]
pub struct Kept {
    folder: PathBuf,
}

impl Kept {
    /// In a folder, which is made.
    #[must_use]
    pub fn new(folder: &Path) -> Self {
        Self {
            folder: folder.to_owned(),
        }
    }

    /// The work of a path: what was counted earlier of the same scene, camera, configuration and
    /// options, and by this version of the program; else it is counted now, and kept. Says
    /// whether it was there.
    ///
    /// # Errors
    /// As [`PathWork::count`]; a folder that cannot be written.
    pub fn path(
        &self,
        scene: &Scene,
        config: &Config,
        options: &PathOptions,
        step: &(dyn Fn() + Sync),
    ) -> Result<(PathWork, bool), KeepError> {
        self.get("path", scene, config, options, || {
            PathWork::count(scene, config, options, step)
        })
    }

    /// The same of the frame that the scene's camera sees.
    ///
    /// # Errors
    /// As [`FrameWork::count`]; a folder that cannot be written.
    pub fn frame(
        &self,
        scene: &Scene,
        config: &Config,
        array: Array,
        cache: u32,
    ) -> Result<(FrameWork, bool), KeepError> {
        let options = FrameOptions {
            array: [array.rows, array.columns],
            is_double_buffered: array.is_double_buffered,
            cache,
        };
        self.get("frame", scene, config, options, || {
            Ok(FrameWork::count(scene, config, array, cache, None)?)
        })
    }

    /// What memory takes for the accesses of a path, kept in the same way.
    ///
    /// # Errors
    /// As [`PathReplay::of`]; a folder that cannot be written.
    pub fn replay(
        &self,
        scene: &Scene,
        config: &Config,
        options: &PathOptions,
        memory: &Memory,
    ) -> Result<PathReplay, KeepError> {
        let key = (options, memory.channels());
        let found = self.get("replay", scene, config, key, || {
            PathReplay::of(scene, config, options, memory)
        })?;
        Ok(found.0)
    }

    fn get<T: Serialize + DeserializeOwned>(
        &self,
        kind: &'static str,
        scene: &Scene,
        config: &Config,
        options: impl Serialize,
        count: impl FnOnce() -> Result<T, PathError>,
    ) -> Result<(T, bool), KeepError> {
        let key = Key {
            version: VERSION,
            program: env!("CARGO_PKG_VERSION"),
            kind,
            configuration: config.hash(),
            scene: scene.name(),
            camera: format!("{:?}", scene.camera()),
            merges: scene.cells().merge,
            halvings: scene.cells().halvings,
            choices: (scene.choices() != Choices::default() || scene.path_length().is_some())
                .then(|| format!("{:?}, still as its reference", scene.choices())),
            manner: scene.manner(),
            options,
            model: scene
                .is_builtin()
                .is_none()
                .then(|| written_down(scene.model())),
        };
        // A key of numbers and text is always written.
        let text = serde_json::to_vec(&key).unwrap_or_default();
        let path = self
            .folder
            .join(format!("{}.json", hex(&Sha256::digest(&text))));
        let bytes = std::fs::read(&path).ok();
        if let Some(work) = bytes.and_then(|bytes| serde_json::from_slice(&bytes).ok()) {
            return Ok((work, true));
        }
        let work = count()?;
        let fail = |source| KeepError::Write {
            path: path.clone(),
            source,
        };
        std::fs::create_dir_all(&self.folder).map_err(fail)?;
        let mut file = tempfile::NamedTempFile::new_in(&self.folder).map_err(fail)?;
        serde_json::to_writer(&mut file, &work).map_err(|e| fail(e.into()))?;
        file.persist(&path).map_err(|e| fail(e.error))?;
        Ok((work, false))
    }
}

#[derive(Serialize, Deserialize)]
struct FrameOptions {
    array: [u64; 2],
    is_double_buffered: bool,
    cache: u32,
}

/// Of what it says of itself.
fn written_down(model: &dyn std::fmt::Debug) -> String {
    struct Hashed(Sha256);
    impl std::fmt::Write for Hashed {
        fn write_str(&mut self, text: &str) -> std::fmt::Result {
            self.0.update(text);
            Ok(())
        }
    }
    let mut hashed = Hashed(Sha256::new());
    // Hashing does not fail.
    let _ = write!(hashed, "{model:?}");
    hex(&hashed.0.finalize())
}

fn hex(hash: &[u8]) -> String {
    hash.iter().take(16).map(|b| format!("{b:02x}")).collect()
}
