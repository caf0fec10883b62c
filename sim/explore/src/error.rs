//! Why a study has no result.

use potamoi_analysis::HardwareError;
use potamoi_formats::config::ConfigError;
use potamoi_netlist::IrErrors;
use potamoi_reference::UnitError;
use potamoi_rtl::RtlError;
use potamoi_scene::SceneError;
use potamoi_synth::SynthError;
use potamoi_system::runtime::RuntimeError;
use potamoi_system::soc::work::WorkCacheError;
use potamoi_system::soc::{CostError, ModelError};
use potamoi_warp::WarpError;
use potamoi_warp::mesh::MeshError;
use thiserror::Error;

/// Why a study has no result: what a crate below says of it, or one of the last
/// three, each a sentence for the user.
#[derive(Debug, Error)]
pub enum ExploreError {
    /// Of the configuration.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// Of a scene, its files or its rendering.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// Of syntheses, their files or their tools.
    #[error(transparent)]
    Synth(#[from] SynthError),
    /// Of the files in which counted work is kept.
    #[error(transparent)]
    Work(#[from] WorkCacheError),
    /// Of the hardware that a scene calls for.
    #[error(transparent)]
    Hardware(#[from] HardwareError),
    /// Of warping.
    #[error(transparent)]
    Warp(#[from] WarpError),
    /// Of the schedule of frames.
    #[error(transparent)]
    Runtime(#[from] RuntimeError),
    /// Of a mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Of Verilog, the tools that run it, or what runs.
    #[error(transparent)]
    Rtl(#[from] RtlError),
    /// Of units that work was sent through.
    #[error("{0}")]
    Unit(UnitError),
    /// Of the system's model.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// Energy or area is not known.
    #[error(transparent)]
    Cost(#[from] CostError),
    /// Of the generated netlist.
    #[error("the generated netlist is wrong: {0}")]
    Netlist(#[from] IrErrors),
    /// A check failed.
    #[error("{0}")]
    Check(String),
    /// A check could not say.
    #[error("{0}")]
    Inconclusive(String),
    /// What was asked for cannot be.
    #[error("{0}")]
    Refused(String),
}
