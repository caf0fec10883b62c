//! Arguments.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use potamoi_formats::config::ExpForm;

use crate::args::Common;
use crate::bench::BenchArgs;
use crate::cache::CacheArgs;
use crate::characterise::CharacteriseArgs;
use crate::compare::CompareArgs;
use crate::cost::CostArgs;
use crate::effects::EffectsArgs;
use crate::emit_unit::EmitUnit;
use crate::estimate::EstimateArgs;
use crate::explain::ExplainArgs;
use crate::explore::ExploreArgs;
use crate::hard_cases::HardCasesArgs;
use crate::init::InitArgs;
use crate::inspect::InspectArgs;
use crate::layouts::LayoutsArgs;
use crate::model::ModelArgs;
use crate::mutate::MutateArgs;
use crate::prove::ProveArgs;
use crate::render::RenderArgs;
use crate::report::ReportArgs;
use crate::report_files::ReportFiles;
use crate::shell_files::{CompletionsArgs, ManArgs};
use crate::sweep::SweepArgs;
use crate::synth::SynthArgs;
use crate::system::SystemArgs;
use crate::trace::TraceArgs;
use crate::verify::VerifyArgs;
use crate::warp::WarpArgs;

/// Hardware generator, golden models and simulation for neural rendering.
#[derive(Debug, Parser)]
#[command(name = "potamoi", version, max_term_width = 98)]
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
    /// Record the inputs of the units for a frame, and the expected results
    Trace(TraceArgs),
    /// Compare the Verilog with the golden models, in every bit and every cycle
    Verify(VerifyArgs),
    /// Prove the assertions in the Verilog of the units
    Prove(ProveArgs),
    /// Put small faults into the netlists of the units, and tell which of them the bench, the
    /// verification and the proofs find
    Mutate(MutateArgs),
    /// Render a scene in floating point, in the hardware's formats, or through
    /// the simulated hardware
    Render(RenderArgs),
    /// Warp frames of a camera path from references, and render the pixels that no reference shows
    Warp(Box<WarpArgs>),
    /// List the effects that a scene and a camera path call for, and the cost or saving of each
    Effects(Box<EffectsArgs>),
    /// Test hard cases of numerics on a configuration and a scene, with the obvious form's failure beside
    HardCases(Box<HardCasesArgs>),
    /// Count memory accesses, cache misses and bank conflicts of a scene, beside the paper's
    Characterise(CharacteriseArgs),
    /// Compare bank organisations by the cycles of a frame's gathers
    Layouts(LayoutsArgs),
    /// Synthesise the units to a cell library: area, clock, memories and power
    Synth(SynthArgs),
    /// Estimate area, clock and energy by formulas fitted to a grid of syntheses
    Estimate(EstimateArgs),
    /// Model the whole system: time, energy and quality of a camera path, by variant
    Model(Box<ModelArgs>),
    /// Compare machines on scenes: frames a second, energy, quality, area and bottleneck, with ratios
    Compare(CompareArgs),
    /// Evaluate every point of a plan over any field of configuration, system, scene and path
    Sweep(SweepArgs),
    /// Search for the best machine within limits, and verify its Verilog
    Explore(Box<ExploreArgs>),
    /// Measure the cost of accuracy in time, energy and area
    Cost(CostArgs),
    /// Tell what a model's file says and holds, and what its format costs beside another
    Inspect(InspectArgs),
    /// Write one page about scenes on machines: pictures, what was verified, time, energy, accuracy,
    /// effects, and where each figure comes from
    Report(ReportArgs),
    /// Explain a field of a file or a knob: meaning, range, default, presets, cost
    Explain(ExplainArgs),
    /// Write a machine's file with every field and its default, and a plan of a sweep
    Init(InitArgs),
    /// Print a system as a description to start from
    System(SystemArgs),
    /// Print the JSON schema of a command's report
    Schema(SchemaArgs),
    /// Print the completions of a shell
    Completions(CompletionsArgs),
    /// Write manual pages of all commands
    Man(ManArgs),
    /// List the results kept between runs, or remove them
    Cache(CacheArgs),
    /// Measure speed beside limits of the machine and peers: renderers, units, verification
    Bench(BenchArgs),
    /// List the external tools: state, version, and the commands that need each
    Doctor(DoctorArgs),
}

#[derive(Debug, Args)]
pub(crate) struct SchemaArgs {
    /// Report of --json: a command's name, with a hyphen before a flag as in model-ladder; without one
    /// all are listed
    #[arg(value_name = "NAME")]
    pub(crate) of: Option<String>,
}

#[derive(Debug, Args)]
pub(crate) struct DoctorArgs {
    #[command(flatten)]
    pub(crate) files: ReportFiles,
}

#[derive(Debug, Args)]
pub(crate) struct EmitArgs {
    /// Folder for the files; it is created if missing, files written earlier by the command are
    /// replaced, and other files stay
    #[arg(long, value_name = "DIR")]
    pub(crate) out_dir: PathBuf,
    /// Replace files of the same names even if they were edited, or not written by this command
    #[arg(long)]
    pub(crate) overwrite: bool,
    /// Hardware unit
    #[arg(long, value_enum, default_value_t = EmitUnit::Both)]
    pub(crate) unit: EmitUnit,
    /// Form of the exponential with its usual settings, with --unit exp; a value of
    /// vu.exp.form [default: the configuration's, with its settings]
    #[arg(long, value_name = "NAME", value_parser = crate::emit_unit::form)]
    pub(crate) form: Option<ExpForm>,
    /// Begin of the names of all modules, so that two configurations meet in one design [default:
    /// none]
    #[arg(long, value_name = "NAME")]
    pub(crate) prefix: Option<String>,
    /// Reduce the configuration to the parts that some camera of this scene can use, and write it
    /// beside the Verilog; a built-in scene, a model file or a description [default: the whole
    /// configuration]
    #[arg(long, value_name = "SCENE")]
    pub(crate) for_scene: Option<String>,
    #[command(flatten)]
    pub(crate) files: ReportFiles,
}
