//! The frozen list of inputs.

use potamoi_scene::Scene;
use serde::Deserialize;

use super::{BenchScene, wrong};
use crate::machine::MachineError;

/// An input of the list.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrozenInput {
    /// Name of the scene.
    pub scene: String,
    /// Width of the picture in pixels.
    pub width: u32,
    /// Digest of the trace.
    pub digest: String,
}

/// The list.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrozenInputs {
    /// Frames of the path whose middle the frame is.
    pub frames: u32,
    /// Inputs in order.
    pub input: Vec<FrozenInput>,
}

impl FrozenInputs {
    /// The list of this crate.
    ///
    /// # Errors
    /// The file is not as it has to be.
    pub fn read() -> Result<Self, MachineError> {
        let text = include_str!("../../frozen.toml");
        toml::from_str(text).map_err(|error| wrong(format!("frozen.toml: {}", error.message())))
    }

    /// Opens its scenes.
    ///
    /// # Errors
    /// A scene that cannot be opened in its size.
    pub fn open(&self) -> Result<Vec<BenchScene>, MachineError> {
        let each = self.input.iter().map(|own| {
            let mut scene = Scene::open(&own.scene).map_err(wrong)?;
            scene.set_size(Some(own.width), None).map_err(wrong)?;
            Ok(BenchScene {
                scene,
                digest: Some(own.digest.clone()),
            })
        });
        each.collect()
    }
}
