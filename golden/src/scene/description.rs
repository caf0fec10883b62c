//! Scene descriptions: TOML files that name a model, a camera and how to render.

use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::SceneError;

/// The largest description, in bytes.
const LIMIT: u64 = 1 << 20;

/// A `scene.toml`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Description {
    /// What is shown.
    pub(super) model: ModelDescription,
    /// From where.
    #[serde(default)]
    pub(super) camera: CameraDescription,
    /// How.
    #[serde(default)]
    pub(super) render: RenderDescription,
}

/// `[model]`.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum ModelDescription {
    /// A scene that is built in.
    Builtin {
        /// Its name.
        name: String,
    },
    /// A 3DGS model file.
    Splats {
        /// PLY file, from the description's folder.
        path: PathBuf,
    },
}

/// `[camera]`. Without it, the model's own.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
pub(super) enum CameraDescription {
    /// The built-in scene's view, or an orbit that frames a model.
    #[default]
    Default,
    /// A camera file in the OpenCV convention.
    OpencvJson {
        /// JSON file, from the description's folder.
        path: PathBuf,
        /// Which camera of the file, from 0.
        #[serde(default)]
        index: usize,
        /// Pixels a row; the file's unless given.
        width: Option<u32>,
        /// Rows; the file's unless given.
        height: Option<u32>,
    },
    /// Looking at a point from a distance.
    Orbit {
        /// Degrees about the vertical axis; the default's unless given.
        azimuth: Option<f64>,
        /// Degrees above the horizon.
        elevation: Option<f64>,
        /// In the scene's units.
        distance: Option<f64>,
        /// Vertical field of view in degrees.
        fov: Option<f64>,
        /// What is in the middle.
        target: Option<[f64; 3]>,
        /// Pixels a row.
        width: Option<u32>,
        /// Rows.
        height: Option<u32>,
    },
}

/// `[render]`.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RenderDescription {
    /// Rule set for splats.
    pub(super) profile: Option<String>,
    /// Linear RGB behind everything.
    pub(super) background: Option<[f32; 3]>,
    /// Columns and rows of tiles of a ray group, for splats.
    pub(super) group_tiles: Option<[u32; 2]>,
    /// Pixels a side of a ray group, for voxels.
    pub(super) group_side: Option<u32>,
    /// Voxel edges from sample to sample, for voxels.
    pub(super) step: Option<f64>,
}

impl Description {
    /// Reads a description.
    ///
    /// # Errors
    /// The file cannot be read or is no description.
    pub(super) fn read(path: &Path) -> Result<Self, SceneError> {
        let fail = |source| SceneError::Read {
            path: path.to_owned(),
            source,
        };
        let bytes = std::fs::metadata(path).map_err(fail)?.len();
        let wrong = |message| SceneError::Description {
            path: path.to_owned(),
            message,
        };
        if bytes > LIMIT {
            return Err(wrong(format!(
                "{bytes} bytes: expected a description of at most {LIMIT}"
            )));
        }
        let text = std::fs::read_to_string(path).map_err(fail)?;
        // Spans name the line and the field.
        toml::from_str(&text).map_err(|e| wrong(e.to_string()))
    }
}
