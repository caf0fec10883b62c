//! What can go wrong between the name of a scene and its picture.

use std::path::PathBuf;

use thiserror::Error;

use super::camera_file::CameraFileError;
use super::colmap::ColmapError;
use super::transforms::TransformsError;
use potamoi_fields::FieldError;
use potamoi_march::MarchError;
use potamoi_splats::files::FileError;
use potamoi_splats::{CloudError, RenderError};
use potamoi_warp::WarpError;
use potamoi_warp::mesh::MeshError;

/// A scene that cannot be opened or rendered.
#[derive(Debug, Error)]
pub enum SceneError {
    /// Neither a built-in name nor a file.
    #[error(
        "scene `{name}`: no built-in scene and no file of that name; built in are {builtin}, \
         and files end in {endings}"
    )]
    Unknown {
        /// What was asked for.
        name: String,
        /// The names that are built in.
        builtin: String,
        /// The endings of files.
        endings: String,
    },
    /// A file of a kind that is not read.
    #[error("scene {path}: {kind} are not read: expected {expected}")]
    Ending {
        /// The file.
        path: PathBuf,
        /// What is not read.
        kind: String,
        /// The endings that are read.
        expected: String,
    },
    /// A model does not fit in memory.
    #[error("cannot load {path}: {why}; raise the limit, or name a smaller model")]
    Memory {
        /// The file.
        path: PathBuf,
        /// What is lacking.
        why: String,
    },
    /// A description cannot be read.
    #[error("cannot read {path}: {source}; name a file that is there and can be read")]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A description is not what it should be.
    #[error("scene {path}: {message}")]
    Description {
        /// The file.
        path: PathBuf,
        /// What is wrong and what was expected.
        message: String,
    },
    /// A value of a description or an argument is out of range.
    #[error("scene {scene}: {field} is {value}: expected {expected}")]
    Value {
        /// The scene.
        scene: String,
        /// The field.
        field: &'static str,
        /// Its value.
        value: String,
        /// What would be right.
        expected: String,
    },
    /// A model file cannot be used.
    #[error(transparent)]
    Model(#[from] FileError),
    /// A camera file cannot be used.
    #[error(transparent)]
    Camera(#[from] CameraFileError),
    /// Gaussians that make no cloud.
    #[error(transparent)]
    Cloud(#[from] CloudError),
    /// Splats cannot be rendered.
    #[error(transparent)]
    Splats(#[from] RenderError),
    /// Voxels cannot be rendered.
    #[error(transparent)]
    Voxels(#[from] MarchError),
    /// A camera path cannot be used.
    #[error(transparent)]
    Path(#[from] TransformsError),
    /// Poses of a reconstruction cannot be used.
    #[error(transparent)]
    Poses(#[from] ColmapError),
    /// A field cannot be loaded or rendered.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// What names no scene itself.
    #[error("scene {scene}: {source}")]
    Of {
        /// The scene.
        scene: String,
        /// What is wrong with it.
        source: Box<SceneError>,
    },
    /// A mesh cannot be made of the model.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The units of a configuration cannot render the scene.
    #[error("configuration: `{field}` is {value}: scene {scene} needs {expected}")]
    Config {
        /// The scene.
        scene: String,
        /// The field.
        field: &'static str,
        /// Its value.
        value: String,
        /// What would do.
        expected: String,
    },
}

impl SceneError {
    /// Names the scene, where the text names neither it nor a file.
    pub(super) fn of(self, scene: &str) -> Self {
        let nameless = match &self {
            Self::Cloud(_) | Self::Splats(_) | Self::Voxels(_) => true,
            Self::Field(error) => !error.names_file(),
            _ => false,
        };
        if !nameless {
            return self;
        }
        Self::Of {
            scene: scene.to_owned(),
            source: Box::new(self),
        }
    }

    /// The error of a unit that stopped the rendering, if that is what it was.
    #[must_use]
    pub fn unit(&self) -> Option<&(dyn std::error::Error + Send + Sync + 'static)> {
        match self {
            Self::Splats(RenderError::Unit(e))
            | Self::Voxels(MarchError::Unit(e))
            | Self::Field(FieldError::Voxels(MarchError::Unit(e))) => Some(&**e),
            Self::Of { source, .. } => source.unit(),
            _ => None,
        }
    }
}

impl From<SceneError> for WarpError {
    fn from(error: SceneError) -> Self {
        Self::Renderer(Box::new(error))
    }
}
