//! What ends a comparison. A tool that is missing does not: its figures are left out, with the reason.

use potamoi_fields::FieldError;
use potamoi_gaussians::CloudError;
use potamoi_scene::SceneError;
use potamoi_splats::RenderError;
use thiserror::Error;

/// Why nothing was compared.
#[derive(Debug, Error)]
pub enum SpeedError {
    /// A scene cannot be opened or rendered.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// The scene is of no section that was asked for.
    #[error("scene {scene}: {found}: expected {expected}")]
    Kind {
        /// The scene.
        scene: String,
        /// What it is.
        found: &'static str,
        /// What to name.
        expected: &'static str,
    },
}

impl From<RenderError> for SpeedError {
    fn from(error: RenderError) -> Self {
        Self::Scene(error.into())
    }
}

impl From<CloudError> for SpeedError {
    fn from(error: CloudError) -> Self {
        Self::Scene(error.into())
    }
}

impl From<FieldError> for SpeedError {
    fn from(error: FieldError) -> Self {
        Self::Scene(error.into())
    }
}
