//! Failures of a command, with their exit codes.

use std::process::ExitCode;

use potamoi_analysis::HardwareError;
use potamoi_base::effects::UnknownEffect;
use potamoi_base::file_set::FileSetError;
use potamoi_base::memory_limit::MemoryLimitError;
use potamoi_base::outputs::FileError;
use potamoi_base::picture::PictureError;
use potamoi_explore::{Cause, ExploreError};
use potamoi_formats::config::ConfigError;
use potamoi_machines::MachineError;
use potamoi_machines::sweep::SweepError;
use potamoi_mutate::MutateError;
use potamoi_netlist::IrErrors;
use potamoi_prove::ProveError;
use potamoi_rtl::RtlError;
use potamoi_scene::SceneError;
use potamoi_scene::trace::TraceError;
use potamoi_speed::SpeedError;
use potamoi_synth::SynthError;
use potamoi_system::path_schedule::ScheduleError;
use potamoi_system::system_model::work::WorkCacheError;
use potamoi_system::system_model::{CostError, ModelError, SystemError};
use potamoi_warp::WarpError;
use potamoi_warp::mesh::MeshError;
use thiserror::Error;

#[derive(Debug, Error)]
pub(crate) enum Failure {
    #[error("{}", .0.told())]
    Explore(Box<ExploreError>),
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    FileSet(#[from] FileSetError),
    #[error(transparent)]
    Memory(#[from] MemoryLimitError),
    #[error(transparent)]
    Picture(#[from] PictureError),
    #[error(transparent)]
    Effect(#[from] UnknownEffect),
    #[error(transparent)]
    Trace(#[from] TraceError),
    #[error(transparent)]
    System(#[from] SystemError),
    #[error(transparent)]
    Machine(Box<MachineError>),
    #[error(transparent)]
    Sweep(Box<SweepError>),
    #[error("{0}")]
    Usage(String),
    /// Required tools cannot be used.
    #[error("{0}")]
    Tools(String),
    /// Part of the output was lost.
    #[error("cannot write standard output: {0}; the printed output is incomplete")]
    Output(String),
}

/// Errors that a study has too.
macro_rules! of_studies {
    ($($error:ty),* $(,)?) => {
        $(impl From<$error> for Failure {
            fn from(error: $error) -> Self {
                Self::Explore(Box::new(error.into()))
            }
        })*
    };
}

of_studies!(
    ExploreError,
    ConfigError,
    IrErrors,
    SceneError,
    HardwareError,
    WarpError,
    ScheduleError,
    MeshError,
    RtlError,
    SynthError,
    WorkCacheError,
    CostError,
    ModelError,
);

impl From<MachineError> for Failure {
    fn from(error: MachineError) -> Self {
        Self::Machine(Box::new(error))
    }
}

impl From<SweepError> for Failure {
    fn from(error: SweepError) -> Self {
        Self::Sweep(Box::new(error))
    }
}

impl From<SpeedError> for Failure {
    fn from(error: SpeedError) -> Self {
        match error {
            SpeedError::Scene(error) => error.into(),
            error => Self::Usage(error.to_string()),
        }
    }
}

impl From<ProveError> for Failure {
    fn from(error: ProveError) -> Self {
        match error {
            ProveError::Netlist(errors) => errors.into(),
            error => Self::Tools(error.to_string()),
        }
    }
}

impl From<MutateError> for Failure {
    fn from(error: MutateError) -> Self {
        match error {
            MutateError::Netlist(errors) => errors.into(),
            MutateError::Bench(error) => error.into(),
            MutateError::Proof(error) => error.into(),
            error => Self::Tools(error.to_string()),
        }
    }
}

impl Failure {
    /// A check failed; its findings were printed before.
    pub(crate) fn check(why: impl Into<String>) -> Self {
        ExploreError::Check(why.into()).into()
    }

    /// A check was inconclusive.
    pub(crate) fn inconclusive(why: impl Into<String>) -> Self {
        ExploreError::Inconclusive(why.into()).into()
    }

    pub(crate) fn exit_code(&self) -> ExitCode {
        ExitCode::from(match self.cause() {
            Cause::Check => 1,
            Cause::Input => 2,
            Cause::Tool => 3,
            Cause::Inconclusive => 4,
        })
    }

    /// Whether a check failed; its findings were printed before.
    pub(crate) fn is_failed_check(&self) -> bool {
        matches!(self, Self::Explore(error) if matches!(**error, ExploreError::Check(_)))
    }

    /// Whether a tool is missing or does not work.
    pub(crate) fn is_of_a_tool(&self) -> bool {
        matches!(self.cause(), Cause::Tool)
    }

    fn cause(&self) -> Cause {
        match self {
            Self::Explore(error) => error.cause(),
            Self::Tools(_) => Cause::Tool,
            Self::File(_)
            | Self::FileSet(_)
            | Self::Memory(_)
            | Self::Picture(_)
            | Self::Effect(_)
            | Self::Trace(_)
            | Self::System(_)
            | Self::Usage(_)
            | Self::Output(_) => Cause::Input,
            Self::Machine(error) => error.cause(),
            Self::Sweep(error) => error.cause(),
        }
    }
}
