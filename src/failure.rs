//! Failures of a command, with their exit codes.

use std::error::Error;
use std::process::ExitCode;

use potamoi_analysis::HardwareError;
use potamoi_base::effects::UnknownEffect;
use potamoi_base::picture::PictureError;
use potamoi_explore::ExploreError;
use potamoi_formats::config::ConfigError;
use potamoi_netlist::IrErrors;
use potamoi_reference::UnitError;
use potamoi_rtl::RtlError;
use potamoi_scene::SceneError;
use potamoi_scene::trace::TraceError;
use potamoi_synth::SynthError;
use potamoi_system::path_schedule::ScheduleError;
use potamoi_system::system_model::work::WorkCacheError;
use potamoi_system::system_model::{CostError, ModelError as SystemModelError, SystemError};
use potamoi_verilated::Error as ModelError;
use potamoi_warp::WarpError;
use potamoi_warp::mesh::MeshError;
use thiserror::Error;

use crate::doctor::DoctorError;
use crate::files::FileError;

#[derive(Debug, Error)]
pub(crate) enum Failure {
    #[error(transparent)]
    Config(#[from] ConfigError),
    #[error("the generated netlist is wrong: {0}")]
    Netlist(#[from] IrErrors),
    #[error(transparent)]
    File(#[from] FileError),
    #[error(transparent)]
    Picture(#[from] PictureError),
    #[error(transparent)]
    Scene(#[from] SceneError),
    #[error(transparent)]
    Effect(#[from] UnknownEffect),
    #[error(transparent)]
    Hardware(#[from] HardwareError),
    #[error(transparent)]
    Warp(#[from] WarpError),
    #[error(transparent)]
    Runtime(#[from] ScheduleError),
    #[error(transparent)]
    Mesh(#[from] MeshError),
    #[error(transparent)]
    Trace(#[from] TraceError),
    /// Units that a trace was sent through.
    #[error("{0}")]
    Unit(UnitError),
    #[error(transparent)]
    Rtl(#[from] RtlError),
    #[error(transparent)]
    Synth(#[from] SynthError),
    #[error(transparent)]
    System(#[from] SystemError),
    #[error(transparent)]
    Work(#[from] WorkCacheError),
    #[error(transparent)]
    Cost(#[from] CostError),
    #[error(transparent)]
    Model(#[from] SystemModelError),
    #[error(transparent)]
    Doctor(#[from] DoctorError),
    /// A check failed; its findings were printed before.
    #[error("{0}")]
    Check(String),
    /// A check was inconclusive.
    #[error("{0}")]
    Inconclusive(String),
    #[error("{0}")]
    Usage(String),
    /// Part of the output was lost.
    #[error("cannot write standard output: {0}; what was printed is not whole")]
    Output(String),
}

impl From<ExploreError> for Failure {
    fn from(error: ExploreError) -> Self {
        match error {
            ExploreError::Config(error) => Self::Config(error),
            ExploreError::Scene(error) => Self::Scene(error),
            ExploreError::Synth(error) => Self::Synth(error),
            ExploreError::Hardware(error) => Self::Hardware(error),
            ExploreError::Warp(error) => Self::Warp(error),
            ExploreError::Runtime(error) => Self::Runtime(error),
            ExploreError::Mesh(error) => Self::Mesh(error),
            ExploreError::Rtl(error) => Self::Rtl(error),
            ExploreError::Unit(error) => Self::Unit(error),
            ExploreError::Work(error) => Self::Work(error),
            ExploreError::Model(error) => Self::Model(error),
            ExploreError::Cost(error) => Self::Cost(error),
            ExploreError::Netlist(error) => Self::Netlist(error),
            ExploreError::Check(why) => Self::Check(why),
            ExploreError::Inconclusive(why) => Self::Inconclusive(why),
            ExploreError::Refused(why) => Self::Usage(why),
        }
    }
}

impl Failure {
    pub(crate) fn exit_code(&self) -> ExitCode {
        ExitCode::from(self.code())
    }

    fn code(&self) -> u8 {
        match self {
            Self::Config(_)
            | Self::File(_)
            | Self::Trace(_)
            | Self::Picture(_)
            | Self::Warp(_)
            | Self::Effect(_)
            | Self::Hardware(_)
            | Self::Runtime(_)
            | Self::Mesh(_)
            | Self::System(_)
            | Self::Work(_)
            | Self::Cost(_)
            | Self::Model(_)
            | Self::Usage(_)
            | Self::Output(_) => 2,
            Self::Netlist(_) | Self::Check(_) => 1,
            Self::Inconclusive(_) => 4,
            Self::Scene(error) => match error.unit() {
                Some(unit) => unit_code(unit),
                None => 2,
            },
            Self::Unit(error) => unit_code(&**error),
            Self::Rtl(error) => rtl_code(error),
            Self::Synth(error) => match error {
                SynthError::MissingTool { .. }
                | SynthError::NoLibrary { .. }
                | SynthError::Broken { .. } => 3,
                SynthError::Tool { .. } | SynthError::Output { .. } | SynthError::Netlist(_) => 1,
                SynthError::Cache(error) => model_code(error),
                SynthError::Rtl(error) => rtl_code(error),
                _ => 2,
            },
            Self::Doctor(error) => match error {
                DoctorError::Missing(_) => 3,
                DoctorError::File(_) | DoctorError::Json(_) => 2,
            },
        }
    }
}

/// Exit code of a failure in a renderer's units, which may be hardware.
fn unit_code(error: &(dyn Error + Send + Sync + 'static)) -> u8 {
    error.downcast_ref::<RtlError>().map_or(2, rtl_code)
}

fn rtl_code(error: &RtlError) -> u8 {
    match error {
        RtlError::MissingTool { .. } | RtlError::BrokenTool { .. } => 3,
        RtlError::Model(error) => model_code(error),
        RtlError::Stream(_) | RtlError::Work(_) | RtlError::Fault(_) | RtlError::Folder(_) => 2,
        _ => 1,
    }
}

/// Exit code of a model that was not built or run: a fault of the machine is no failed check.
fn model_code(error: &ModelError) -> u8 {
    match error {
        ModelError::MissingTool { .. }
        | ModelError::OldTool { .. }
        | ModelError::Broken { .. }
        | ModelError::Load { .. } => 3,
        ModelError::NoCacheDir
        | ModelError::NoFolder { .. }
        | ModelError::Untrusted { .. }
        | ModelError::Io { .. } => 2,
        _ => 1,
    }
}
