//! Errors of scenes.

use std::path::PathBuf;

use thiserror::Error;

use super::camera_file::CameraFileError;
use super::colmap::ColmapError;
use super::trajectory::TrajectoryError;
use super::transforms::TransformsError;
use potamoi_fields::FieldError;
use potamoi_gaussians::CloudError;
use potamoi_gaussians::files::FileError;
use potamoi_march::MarchError;
use potamoi_reference::UnitError;
use potamoi_splats::RenderError;
use potamoi_warp::WarpError;
use potamoi_warp::mesh::MeshError;

/// A scene that cannot be opened or rendered.
#[derive(Debug, Error)]
pub enum SceneError {
    /// The name is neither a built-in scene nor a file.
    #[error(
        "scene `{name}`: no built-in scene and no file of that name; built in are {builtin}, \
         and files end in {endings}"
    )]
    Unknown {
        /// The requested name.
        name: String,
        /// Names of the built-in scenes.
        builtin: String,
        /// Extensions of scene files.
        endings: String,
    },
    /// The kind of file is not supported.
    #[error("scene {path}: {kind} are not read: expected {expected}")]
    Ending {
        /// The file.
        path: PathBuf,
        /// The kind of the file.
        kind: String,
        /// The supported extensions.
        expected: String,
    },
    /// A `[render]` section that is not a scene's.
    #[error("{message}")]
    RenderSection {
        /// The problem, with its field.
        message: String,
    },
    /// The model does not fit in memory.
    #[error("cannot load {path}: {why}; raise the limit, or name a smaller model")]
    Memory {
        /// The file.
        path: PathBuf,
        /// The part that does not fit, with its size.
        why: String,
    },
    /// A description cannot be read.
    #[error("cannot read {path}: {source}; name a file that is there and can be read")]
    Read {
        /// The file.
        path: PathBuf,
        /// The error of the file system.
        source: std::io::Error,
    },
    /// A description is invalid.
    #[error("scene {path}: {message}")]
    Description {
        /// The file.
        path: PathBuf,
        /// The problem and the expected content.
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
        /// Allowed values.
        expected: String,
    },
    /// A model file is invalid or not supported.
    #[error(transparent)]
    Model(#[from] FileError),
    /// A camera file is invalid or not supported.
    #[error(transparent)]
    Camera(#[from] CameraFileError),
    /// The Gaussians do not form a valid cloud.
    #[error(transparent)]
    Cloud(#[from] CloudError),
    /// Splats cannot be rendered.
    #[error(transparent)]
    Splats(#[from] RenderError),
    /// Voxels cannot be rendered.
    #[error(transparent)]
    Voxels(#[from] MarchError),
    /// A camera path is invalid or not supported.
    #[error(transparent)]
    Path(#[from] TransformsError),
    /// Poses of a reconstruction are invalid or not supported.
    #[error(transparent)]
    Poses(#[from] ColmapError),
    /// A recorded motion is invalid or not supported.
    #[error(transparent)]
    Trajectory(#[from] TrajectoryError),
    /// A field cannot be loaded or rendered.
    #[error(transparent)]
    Field(#[from] FieldError),
    /// An error that does not name the scene itself.
    #[error("scene {scene}: {source}")]
    Of {
        /// The scene.
        scene: String,
        /// The error.
        source: Box<SceneError>,
    },
    /// No mesh can be made from the model.
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
        /// Allowed values.
        expected: String,
    },
}

impl SceneError {
    /// A unit that refused its work or failed.
    #[must_use]
    pub const fn of_unit(error: UnitError) -> Self {
        Self::Voxels(MarchError::Unit(error))
    }

    /// Adds the name of the scene, unless the message names it or a file.
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

    /// The error of the unit that stopped rendering, if any.
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
