//! Work that was counted is kept, by what it was counted of.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use potamoi_formats::config::Config;
use potamoi_golden::scene::Scene;
use serde::Serialize;
use sha2::{Digest, Sha256};
use thiserror::Error;

use super::path::{PathError, PathOptions, PathWork};

/// Raised where what is counted changes.
const VERSION: u32 = 1;

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

#[derive(Serialize)]
struct Key<'a> {
    version: u32,
    program: &'static str,
    configuration: String,
    scene: &'a str,
    camera: String,
    options: &'a PathOptions,
    /// Of a model that was read from a file: what was read.
    model: Option<String>,
}

/// The work of a path: what was counted earlier of the same scene, camera, configuration and
/// options, and by this version of the program; else it is counted now, and kept. Says whether
/// it was there.
///
/// # Errors
/// As [`PathWork::count`]; a folder that cannot be written.
pub fn kept(
    folder: &Path,
    scene: &Scene,
    config: &Config,
    options: &PathOptions,
    step: &mut dyn FnMut(),
) -> Result<(PathWork, bool), KeepError> {
    let key = Key {
        version: VERSION,
        program: env!("CARGO_PKG_VERSION"),
        configuration: config.hash(),
        scene: scene.name(),
        camera: format!("{:?}", scene.camera()),
        options,
        // Its numbers, whatever the file.
        model: scene
            .analytic()
            .is_none()
            .then(|| written_down(scene.model())),
    };
    // A key of numbers and text is always written.
    let text = serde_json::to_vec(&key).unwrap_or_default();
    let path = folder.join(format!("{}.json", digest(&text)));
    if let Some(work) = std::fs::read(&path)
        .ok()
        .and_then(|bytes| serde_json::from_slice(&bytes).ok())
    {
        return Ok((work, true));
    }
    let work = PathWork::count(scene, config, options, step)?;
    let fail = |source| KeepError::Write {
        path: path.clone(),
        source,
    };
    std::fs::create_dir_all(folder).map_err(fail)?;
    let mut file = tempfile::NamedTempFile::new_in(folder).map_err(fail)?;
    serde_json::to_writer(&mut file, &work).map_err(|e| fail(e.into()))?;
    file.persist(&path).map_err(|e| fail(e.error))?;
    Ok((work, false))
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

fn digest(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

fn hex(hash: &[u8]) -> String {
    hash.iter().take(16).map(|b| format!("{b:02x}")).collect()
}
