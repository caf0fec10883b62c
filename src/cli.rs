//! Arguments.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use crate::args::Common;
use crate::cache::CacheArgs;
use crate::characterise::CharacteriseArgs;
use crate::cost::CostArgs;
use crate::effects::EffectsArgs;
use crate::estimate::EstimateArgs;
use crate::layouts::LayoutsArgs;
use crate::model::ModelArgs;
use crate::render::RenderArgs;
use crate::synth::SynthArgs;
use crate::trace::TraceArgs;
use crate::verify::VerifyArgs;
use crate::warp::WarpArgs;

/// Hardware generator, golden models and simulation for neural rendering.
#[derive(Debug, Parser)]
#[command(name = "potamoi", version)]
pub(crate) struct Cli {
    #[command(flatten)]
    pub(crate) common: Common,
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Write the Verilog of the units
    Emit(EmitArgs),
    /// Record what goes through the units for a frame, and what must come out
    Trace(TraceArgs),
    /// Prove the Verilog equal to the golden models, every bit and every cycle
    Verify(VerifyArgs),
    /// Render a scene in floating point, in the hardware's formats, or through
    /// the simulated hardware
    Render(RenderArgs),
    /// Warp frames of a camera path from references, and render what those do not show
    Warp(Box<WarpArgs>),
    /// Find which effects a scene and a camera path call for, and what leaving out the others saves
    Effects(Box<EffectsArgs>),
    /// Count what a scene's accesses do to memory and banks, beside the paper
    Characterise(CharacteriseArgs),
    /// Compare the organisations of the banks: cycles of a frame's gathers in each
    Layouts(LayoutsArgs),
    /// Synthesise the units to cells of a library: area, clock, memories
    Synth(SynthArgs),
    /// Estimate what synthesis would find, by formulas fitted to a grid of syntheses
    Estimate(EstimateArgs),
    /// Model the whole system: time, energy and quality of a path of frames by variant
    Model(Box<ModelArgs>),
    /// Measure what accuracy costs in time
    Cost(CostArgs),
    /// List what is kept between runs, or remove it
    Cache(CacheArgs),
    /// Show which outside tools are here, and what is lost without each
    Doctor(DoctorArgs),
}

#[derive(Debug, Args)]
pub(crate) struct DoctorArgs {
    /// Write the report as JSON; of several scenes or frames, one report of all
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct EmitArgs {
    /// Folder for the files: it is made where there is none, files that the command wrote earlier
    /// are replaced, and others stay
    #[arg(long, value_name = "DIR")]
    pub(crate) out_dir: PathBuf,
    /// Replace files of the same names that were edited, or that this command did not write
    #[arg(long)]
    pub(crate) overwrite: bool,
    /// Leave out of the configuration what no camera of this scene can use, and write the reduced
    /// configuration beside the Verilog: a built-in scene, a model file or a description [default: the whole
    /// configuration]
    #[arg(long, value_name = "SCENE")]
    pub(crate) for_scene: Option<String>,
    /// Write the report as JSON; of several scenes or frames, one report of all
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
}
