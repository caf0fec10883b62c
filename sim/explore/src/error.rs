//! Errors of studies.

use potamoi_analysis::HardwareError;
use potamoi_formats::config::ConfigError;
use potamoi_netlist::IrErrors;
use potamoi_reference::UnitError;
use potamoi_rtl::RtlError;
use potamoi_scene::SceneError;
use potamoi_synth::SynthError;
use potamoi_system::path_schedule::ScheduleError;
use potamoi_system::system_model::work::WorkCacheError;
use potamoi_system::system_model::{CostError, ModelError};
use potamoi_warp::WarpError;
use potamoi_warp::mesh::MeshError;
use thiserror::Error;

/// Why a study has no result: an error of a crate below, or one of the last three, each a sentence
/// for the user.
#[derive(Debug, Error)]
pub enum ExploreError {
    /// The configuration is invalid.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// A scene, its files or its rendering failed.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A synthesis, its files or its tools failed.
    #[error(transparent)]
    Synth(#[from] SynthError),
    /// The cache of counted work failed.
    #[error(transparent)]
    Work(#[from] WorkCacheError),
    /// The hardware for a scene cannot be built.
    #[error(transparent)]
    Hardware(#[from] HardwareError),
    /// Warping failed.
    #[error(transparent)]
    Warp(#[from] WarpError),
    /// Scheduling of frames failed.
    #[error(transparent)]
    Runtime(#[from] ScheduleError),
    /// A mesh is invalid.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Verilog, the tools that run it, or its run failed.
    #[error(transparent)]
    Rtl(#[from] RtlError),
    /// A unit failed.
    #[error("{0}")]
    Unit(UnitError),
    /// The system model failed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// An energy or area is not known.
    #[error(transparent)]
    Cost(#[from] CostError),
    /// Measured rows of GPUs cannot be read.
    #[error(transparent)]
    Rows(#[from] potamoi_gpu::rows::RowError),
    /// A program refuses a row's counts.
    #[error(transparent)]
    Counts(#[from] potamoi_gpu::programs::CountError),
    /// The generated netlist is invalid.
    #[error("the generated netlist is invalid: {0}")]
    Netlist(#[from] IrErrors),
    /// A check failed.
    #[error("{0}")]
    Check(String),
    /// A check was inconclusive.
    #[error("{0}")]
    Inconclusive(String),
    /// The request cannot be met.
    #[error("{0}")]
    Refused(String),
}
