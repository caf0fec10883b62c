//! What many machines have in common, read once.

use std::collections::HashMap;
use std::path::Path;
use std::sync::{Mutex, OnceLock, PoisonError};

use potamoi_formats::config::{Config, PRESETS};
use potamoi_formats::document::{self, Value};
use potamoi_system::system_model::System;

use super::MachineError;

/// A preset: its name, its document and its configuration.
pub(super) struct Preset {
    pub(super) name: &'static str,
    pub(super) document: Value,
    pub(super) config: Config,
}

/// All presets.
pub(super) fn presets() -> &'static [Preset] {
    static READ: OnceLock<Vec<Preset>> = OnceLock::new();
    READ.get_or_init(|| {
        let all = PRESETS.iter().filter_map(|(name, text)| {
            Some(Preset {
                name,
                document: document::toml(text.as_bytes()).ok()?,
                config: Config::preset(name)?,
            })
        });
        all.collect()
    })
}

/// The system of a section. Equal sections of one folder are read once: points of a sweep have few systems
/// among them, and each names files of devices.
pub(super) fn system(section: Value, name: &str, folder: &Path) -> Result<System, MachineError> {
    static READ: OnceLock<Mutex<HashMap<String, System>>> = OnceLock::new();
    let known = || {
        let all = READ.get_or_init(Mutex::default);
        all.lock().unwrap_or_else(PoisonError::into_inner)
    };
    let key = format!("{folder:?} {section:?}");
    if let Some(found) = known().get(&key) {
        return Ok(found.clone());
    }
    let read = System::of_document(section, name, folder)?;
    known().insert(key, read.clone());
    Ok(read)
}
