//! What every subcommand takes.

use std::path::{Path, PathBuf};

use clap::Args;
use potamoi_explore::ConfigChoice;
use potamoi_formats::config::{Config, PRESETS};
use potamoi_machines::Machine;
use potamoi_machines::machine::Section;
use potamoi_scene::Scene;

use crate::failure::Failure;
use crate::refusals::{self, WITHOUT_CONFIGURATION};

/// What a command uses that names none.
const DEFAULT_PRESET: &str = "paper";

/// Sections of a machine's file that a command uses beside the configuration.
fn sections_used(command: &str) -> &'static [Section] {
    match command {
        "model" | "compare" | "sweep" | "explore" | "report" => &Section::ALL,
        "cost" => &[Section::System, Section::Render],
        "render" | "hard-cases" | "inspect" | "verify" | "trace" | "effects" | "characterise"
        | "layouts" | "mutate" => &[Section::Render],
        _ => &[],
    }
}

/// Options of all subcommands.
#[derive(Debug, Default, Args)]
pub(crate) struct Common {
    #[arg(long, global = true, value_name = "FILE", help = config_help())]
    pub(crate) config: Option<PathBuf>,
    /// Print all columns of tables; without it a line has a hundred characters at most
    #[arg(long, global = true)]
    pub(crate) wide: bool,
}

/// The help of `--config`, with every preset.
pub(crate) fn config_help() -> String {
    let names = PRESETS.map(|(name, _)| name).join(", ");
    format!("Configuration file, or a preset: {names} [default: {DEFAULT_PRESET}]")
}

impl Common {
    /// The machine that was asked for.
    pub(crate) fn machine(&self) -> Result<Machine, Failure> {
        Ok(match &self.config {
            None => Machine::for_any_scene()?,
            Some(given) => Machine::named(&given.to_string_lossy())?,
        })
    }

    /// The configuration that was asked for.
    pub(crate) fn read_config(&self) -> Result<Config, Failure> {
        let hardware = self.machine()?.hardware;
        Ok(hardware.map_or_else(Config::paper, |own| own.config))
    }

    /// The configuration that was asked for; where none was, the preset that has what the scene's
    /// model needs.
    pub(crate) fn chosen_for(&self, scene: &Scene) -> Result<ConfigChoice, Failure> {
        Ok(self.machine()?.hardware_for(scene)?)
    }

    /// Says which parts of the machine's file a command does not use, and which of its keys are old.
    pub(crate) fn remark_unused(&self, command: &str) -> Result<(), Failure> {
        let machine = self.machine()?;
        if let Some(note) = machine.note() {
            crate::stdout::remark(format_args!("{note}"));
        }
        let used = sections_used(command);
        let unused: Vec<String> = (machine.sections().into_iter())
            .filter(|own| !used.contains(own))
            .map(|own| format!("[{}]", own.name()))
            .collect();
        if !unused.is_empty() {
            crate::stdout::remark(format_args!(
                "{}: {command} does not use {}",
                machine.name,
                unused.join(", ")
            ));
        }
        Ok(())
    }

    /// Refuses a configuration that the command would not use.
    pub(crate) fn check(&self, command: &str) -> Result<(), Failure> {
        match WITHOUT_CONFIGURATION.contains(&command) {
            true => self.refuse_config(command),
            false if self.config.is_none() => Ok(()),
            false => self.remark_unused(command),
        }
    }

    /// Refuses any configuration, of which a command, or one with some flag, has no use.
    pub(crate) fn refuse_config(&self, command: &str) -> Result<(), Failure> {
        match &self.config {
            None => Ok(()),
            Some(path) => Err(Failure::Usage(format!(
                "--config {}: {}",
                path.display(),
                refusals::no_configuration(command)
            ))),
        }
    }

    /// The preset that was asked for, if it was one.
    pub(crate) fn preset(&self) -> Option<&'static str> {
        let named = self.config.as_deref().unwrap_or(Path::new(DEFAULT_PRESET));
        let mut names = PRESETS.into_iter().map(|(name, _)| name);
        names.find(|name| named == Path::new(name))
    }

    /// How the configuration is named on a command line.
    pub(crate) fn arguments(&self) -> String {
        self.config
            .as_ref()
            .map_or_else(String::new, |path| format!(" --config {}", quoted(path)))
    }
}

/// The clock of commands that turn cycles into time.
#[derive(Debug, Default, Args)]
pub(crate) struct ClockArgs {
    /// Clock of the accelerator, whatever its blocks reach; figures at it are marked [default: the
    /// configuration's, or 1 over the longest period of its blocks as synthesised]
    #[arg(long, value_name = "GHZ")]
    assume_clock: Option<f64>,
}

impl ClockArgs {
    /// Whether a clock is assumed.
    pub(crate) const fn is_assumed(&self) -> bool {
        self.assume_clock.is_some()
    }

    /// A configuration with the assumed clock, if there is one.
    pub(crate) fn chosen(&self, chosen: ConfigChoice) -> Result<ConfigChoice, Failure> {
        let Some(ghz) = self.assume_clock else {
            return Ok(chosen);
        };
        let mhz = (1e3 * ghz).round();
        if !(1.0..=10_000.0).contains(&mhz) || (1e3 * ghz - mhz).abs() > 1e-6 {
            let expected = "expected 0.001 to 10 GHz, a multiple of 0.001";
            return Err(Failure::Usage(format!("--assume-clock {ghz}: {expected}")));
        }
        let config = Config {
            clock_mhz: Some(mhz as u32),
            ..chosen.config
        };
        Ok(ConfigChoice { config, ..chosen })
    }
}

/// A path as a shell takes it.
pub(crate) fn quoted(path: &Path) -> String {
    shell_words::quote(&path.to_string_lossy()).into_owned()
}
