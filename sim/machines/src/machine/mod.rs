//! A machine: hardware, the system around it, how a scene is rendered on it, and how its paths are.

mod error;
mod known;
mod path_section;
mod sections;
#[cfg(test)]
mod tests;

use std::path::{Path, PathBuf};

use potamoi_explore::{ConfigChoice, Syntheses};
use potamoi_formats::config::{Config, PRESETS};
use potamoi_formats::device_file::is_file;
use potamoi_formats::document::{self, Value, Wrong};
use potamoi_scene::Scene;
use potamoi_system::system_model::System;

pub use error::MachineError;
pub use path_section::PathSection;
pub use sections::Section;
use sections::{CLOCK, PRESET, REACHED, RENDER, SYSTEM, WITHOUT};

/// A machine as its file describes it.
///
/// The file is that of a configuration, with up to four more keys: `preset`, whose configuration
/// holds where the file names nothing else, and the sections `[system]`, `[render]` and `[path]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Machine {
    /// Name in tables: a preset, a file, or a point of a sweep.
    pub name: String,
    /// Configuration; `None` where nothing names one, so that each scene has the preset it needs.
    pub hardware: Option<ConfigChoice>,
    /// The system around the units.
    pub system: System,
    /// How the frames of a path are rendered.
    pub path: PathSection,
    /// `[render]`, without the effects that are left out.
    render: Option<Value>,
    /// Effects that are left out.
    without: Vec<String>,
    /// All keys as given.
    document: Value,
    /// Folder that paths of device files are relative to.
    folder: PathBuf,
    /// Note on a key of the previous version.
    note: Option<String>,
    /// Syntheses of units beside those that come with the program.
    syntheses: Syntheses,
}

/// Fields that name devices, or files of devices.
const DEVICES: [&str; 3] = ["system.gpu.device", "system.remote.device", "system.memory"];

/// A value as a command line has it.
pub(crate) fn shown(value: &Value) -> String {
    match value {
        Value::Text(text) => text.to_string(),
        other => document::to_toml(other).map_or_else(String::new, |own| own.to_string()),
    }
}

/// A value of a report as [`shown`] has it.
fn in_toml(value: &serde_json::Value) -> String {
    match value {
        serde_json::Value::Array(all) => {
            let each: Vec<String> = all.iter().map(in_toml).collect();
            format!("[{}]", each.join(", "))
        }
        other => other.to_string(),
    }
}

impl Machine {
    /// The machine that a command line names: a preset, or a file.
    ///
    /// # Errors
    /// A name that is no preset and no file, or as [`Machine::of_document`].
    pub fn named(given: &str) -> Result<Self, MachineError> {
        match PRESETS.iter().any(|(name, _)| *name == given) {
            true => Self::of_document(given, Value::Text(given.into()).at(PRESET), Path::new("")),
            false => Self::read(Path::new(given)),
        }
    }

    /// The paper's system, on which each scene has the preset that its model needs.
    ///
    /// # Errors
    /// None for the presets that come with the program.
    pub fn for_any_scene() -> Result<Self, MachineError> {
        Self::of_document("default", Value::Map([].into()), Path::new(""))
    }

    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read, or as [`Machine::of_document`].
    pub fn read(path: &Path) -> Result<Self, MachineError> {
        let document = Config::document_of(path)?;
        let folder = path.parent().unwrap_or(Path::new(""));
        Self::of_document(&path.display().to_string(), document, folder)
    }

    /// The machine of a document. `folder` is that of its file: paths of device files are relative
    /// to it.
    ///
    /// # Errors
    /// An unknown key or section, a value of the wrong type or out of range, a broken rule of the
    /// configuration.
    pub fn of_document(name: &str, document: Value, folder: &Path) -> Result<Self, MachineError> {
        let parts = sections::Parts::of(name, document.clone())?;
        let (hardware, note) = match parts.hardware {
            None => (None, None),
            Some(hardware) => {
                let (config, note) =
                    Config::from_document(hardware, name).map_err(sections::with_sections)?;
                let preset = known::presets().iter().find(|own| own.config == config);
                let preset = preset.map(|own| own.name);
                (Some(ConfigChoice { config, preset }), note)
            }
        };
        let system = match parts.system {
            None => System::default(),
            Some(own) => known::system(own, &format!("{name}: [{SYSTEM}]"), folder)?,
        };
        let (render, without) = match parts.render {
            None => (None, vec![]),
            Some(own) => {
                let without = own.get(WITHOUT).map(|list| list.read::<Vec<String>>());
                let without = without.transpose().map_err(|wrong: Wrong| {
                    MachineError::wrong(name, &wrong.under(WITHOUT).under(RENDER))
                })?;
                let rest = own.without(WITHOUT);
                let is_empty = matches!(&rest, Value::Map(all) if all.is_empty());
                ((!is_empty).then_some(rest), without.unwrap_or_default())
            }
        };
        let path = match parts.path {
            None => PathSection::default(),
            Some(own) => PathSection::of(name, &own)?,
        };
        Ok(Self {
            name: name.to_owned(),
            hardware,
            system,
            path,
            render,
            without,
            document,
            folder: folder.to_owned(),
            note: note.map(|note| format!("{name}: {note}")),
            syntheses: Syntheses::default(),
        })
    }

    /// The machine with the value at a path of its document changed, such as `vu.lanes` or
    /// `system.memory_channels`. `clock_ghz = "reached"` gives the clock back to synthesis.
    ///
    /// # Errors
    /// As [`Machine::of_document`].
    pub fn with(&self, name: &str, changes: &[(&str, Value)]) -> Result<Self, MachineError> {
        let mut document = self.document.clone();
        for (path, value) in changes {
            document = match (*path, value.text()) {
                (CLOCK, Some(REACHED)) => document.without(CLOCK),
                _ => value.clone().at(path).over(document),
            };
        }
        let own = Self::of_document(name, document, &self.folder)?;
        Ok(own.knowing(&self.syntheses))
    }

    /// The same machine, whose units have the figures of these syntheses where one of them has the unit.
    #[must_use]
    pub fn knowing(self, syntheses: &Syntheses) -> Self {
        Self {
            syntheses: syntheses.clone(),
            ..self
        }
    }

    /// The syntheses that it knows.
    #[must_use]
    pub const fn syntheses(&self) -> &Syntheses {
        &self.syntheses
    }

    /// The same machine under another name.
    #[must_use]
    pub fn renamed(self, name: &str) -> Self {
        Self {
            name: name.to_owned(),
            ..self
        }
    }

    /// Folder that paths of device files are relative to.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The same machine with another system, as a description or a device names it.
    #[must_use]
    pub fn around(self, system: System) -> Self {
        Self { system, ..self }
    }

    /// The value of a field as a machine's file has it; `None` where it is neither named nor has a
    /// default, such as a render setting of the scene.
    #[must_use]
    pub fn value(&self, field: &str) -> Option<String> {
        let given = self.document.find(field).map(shown);
        let default = || {
            let config = self.hardware.as_ref().map(|own| &own.config);
            let whole = match field.strip_prefix("system.") {
                Some(_) => serde_json::json!({ "system": &self.system }),
                None => serde_json::to_value(config?).ok()?,
            };
            let pointer = format!("/{}", field.replace('.', "/"));
            let found = whole.pointer(&pointer).filter(|own| !own.is_null())?;
            Some(match found.as_str() {
                Some(text) => text.to_owned(),
                None => in_toml(found),
            })
        };
        given.or_else(default)
    }

    /// Sections that the file has beside the configuration.
    #[must_use]
    pub fn sections(&self) -> Vec<Section> {
        let has = |own: &Section| self.document.get(own.name()).is_some();
        Section::ALL.into_iter().filter(has).collect()
    }

    /// A note for the user on a key of the previous version.
    #[must_use]
    pub fn note(&self) -> Option<&str> {
        self.note.as_deref()
    }

    /// The configuration; the preset that the scene needs where the machine names none.
    ///
    /// # Errors
    /// None for the presets that come with the program.
    pub fn hardware_for(&self, scene: &Scene) -> Result<ConfigChoice, MachineError> {
        match &self.hardware {
            Some(own) => Ok(own.clone()),
            None => Ok(ConfigChoice::for_scene(scene)?),
        }
    }

    /// The render settings in a fixed form.
    pub(crate) fn render_key(&self) -> String {
        format!("{:?} {:?}", self.render, self.without)
    }

    /// Applies the machine's render settings to a scene.
    ///
    /// # Errors
    /// A key that is not for the scene's model, a value out of range, an unknown effect.
    pub fn prepare(&self, scene: &mut Scene) -> Result<(), MachineError> {
        let within = |source| MachineError::Render {
            name: self.name.clone(),
            source: Box::new(source),
        };
        if let Some(render) = &self.render {
            scene.apply_render(render).map_err(within)?;
        }
        let mut choices = scene.choices();
        for effect in &self.without {
            let named = potamoi_base::effects::Choices::named(effect);
            let named = named.map_err(|error| MachineError::Effect {
                name: self.name.clone(),
                problem: error.to_string(),
            })?;
            choices = (named.into_iter()).fold(choices, |own, effect| own.leave_out(effect));
        }
        scene.set_choices(choices);
        Ok(())
    }

    /// The document in a fixed form: what a machine is, whatever its name. A preset is written out,
    /// defaults are not.
    #[must_use]
    pub fn identity(&self) -> blake3::Hash {
        let config = self.hardware.as_ref().map(|own| &own.config);
        potamoi_base::content_hash::hash_of(&(
            config,
            self.system.identity().as_bytes(),
            self.render.as_ref().and_then(document::to_toml),
            &self.without,
            &self.path,
            self.syntheses.identity().map(|own| *own.as_bytes()),
        ))
    }

    /// The document with device files by their whole paths: the file that is written may lie elsewhere.
    fn with_whole_paths(&self) -> Value {
        let mut document = self.document.clone();
        for field in DEVICES {
            let file = document.find(field).and_then(Value::text);
            let file = file
                .filter(|own| is_file(own))
                .map(|own| self.folder.join(own));
            let Some(file) = file else { continue };
            let whole = std::path::absolute(&file).unwrap_or(file);
            let whole = Value::Text(whole.to_string_lossy().into());
            document = whole.at(field).over(document);
        }
        document
    }

    /// The machine's file.
    ///
    /// # Errors
    /// A value that TOML cannot hold.
    pub fn to_toml(&self) -> Result<String, MachineError> {
        let unwritable = |problem: String| MachineError::Unwritable {
            name: self.name.clone(),
            problem,
        };
        let table = document::to_toml(&self.with_whole_paths());
        let table = table.ok_or_else(|| unwritable("it has no keys".to_owned()))?;
        toml::to_string(&table).map_err(|error| unwritable(error.to_string()))
    }
}
