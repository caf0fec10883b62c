//! Arguments.

use std::path::{Path, PathBuf};

use clap::{Args, Parser, Subcommand};
use potamoi_formats::config::{Config, PRESETS};

use crate::cost::CostArgs;
use crate::failure::Failure;
use crate::render::RenderArgs;
use crate::trace::TraceArgs;
use crate::verify::VerifyArgs;

/// Hardware generator, golden models and simulation for neural rendering.
#[derive(Debug, Parser)]
#[command(name = "potamoi", version)]
pub(crate) struct Cli {
    #[command(flatten)]
    pub(crate) common: Common,
    #[command(subcommand)]
    pub(crate) command: Command,
}

/// What every subcommand takes.
#[derive(Debug, Args)]
pub(crate) struct Common {
    /// Configuration file, or a preset: paper (unless given), small
    #[arg(long, global = true, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
}

/// What a command uses that names none.
const DEFAULT_PRESET: &str = "paper";

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
    /// Measure what accuracy costs in time
    Cost(CostArgs),
    /// Show which outside tools are here, and what is lost without each
    Doctor(DoctorArgs),
}

#[derive(Debug, Args)]
pub(crate) struct DoctorArgs {
    /// Report as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
}

#[derive(Debug, Args)]
pub(crate) struct EmitArgs {
    /// Folder that is made, or filled
    #[arg(long, value_name = "DIR")]
    pub(crate) out: PathBuf,
}

impl Common {
    /// The configuration that was asked for.
    pub(crate) fn read_config(&self) -> Result<Config, Failure> {
        let path = self.config.as_deref().unwrap_or(Path::new(DEFAULT_PRESET));
        for (name, text) in PRESETS {
            if path == Path::new(name) {
                return Ok(Config::from_toml(text, &format!("preset {name}"))?);
            }
        }
        Ok(Config::read(path)?)
    }

    /// How the configuration is named on a command line.
    pub(crate) fn arguments(&self) -> String {
        self.config
            .as_ref()
            .map_or_else(String::new, |path| format!(" --config {}", path.display()))
    }
}
