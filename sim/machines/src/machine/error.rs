//! Errors of machines.

use potamoi_explore::{Cause, ExploreError};
use potamoi_formats::config::ConfigError;
use potamoi_formats::document::Wrong;
use potamoi_scene::SceneError;
use potamoi_system::system_model::SystemError;
use thiserror::Error;

/// Why a file or a point describes no machine.
#[derive(Debug, Error)]
pub enum MachineError {
    /// Its configuration cannot be read or breaks rules.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// Its `[system]` is none.
    #[error(transparent)]
    System(#[from] SystemError),
    /// A key or a value outside the configuration.
    #[error("{name}: field `{field}`: {problem}")]
    Field {
        /// The machine.
        name: String,
        /// Path of the field.
        field: String,
        /// The problem.
        problem: String,
    },
    /// Its `[render]` is not for the scene.
    #[error("{name}: {source}")]
    Render {
        /// The machine.
        name: String,
        /// The problem.
        source: Box<SceneError>,
    },
    /// It leaves out an effect that is none.
    #[error("{name}: field `render.without`: {problem}")]
    Effect {
        /// The machine.
        name: String,
        /// The problem.
        problem: String,
    },
    /// The demands of a frame say nothing of warped frames.
    #[error(
        "{name}: variant {variant}: expected full frames: times by demand are those of a frame alone; \
         the schedule has warped and scaled ones"
    )]
    Demand {
        /// The machine.
        name: String,
        /// Its variant.
        variant: &'static str,
    },
    /// It cannot be written.
    #[error("{name}: cannot be written as TOML: {problem}")]
    Unwritable {
        /// The machine.
        name: String,
        /// The problem.
        problem: String,
    },
    /// The fair bench cannot be run.
    #[error("{problem}")]
    Bench {
        /// The problem.
        problem: String,
    },
    /// Its configuration for a scene cannot be made.
    #[error(transparent)]
    Explore(#[from] Box<ExploreError>),
}

impl MachineError {
    /// Where its cause is.
    #[must_use]
    pub fn cause(&self) -> Cause {
        match self {
            Self::Explore(error) => error.cause(),
            _ => Cause::Input,
        }
    }

    /// Whether values that are each allowed do not go together.
    #[must_use]
    pub const fn is_rule(&self) -> bool {
        matches!(
            self,
            Self::Config(ConfigError::Rules { .. }) | Self::System(SystemError::Together { .. })
        )
    }

    pub(super) fn wrong(name: &str, wrong: &Wrong) -> Self {
        Self::Field {
            name: name.to_owned(),
            field: wrong.field(),
            problem: wrong.problem().to_owned(),
        }
    }
}

impl From<ExploreError> for MachineError {
    fn from(error: ExploreError) -> Self {
        Self::Explore(Box::new(error))
    }
}
