//! Drives the splat unit on any engine.

mod beats;
mod drive;
mod seen;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use potamoi_cycles::splat_unit::SplatCounters;
use potamoi_cycles::{Plan, Stalls};
use potamoi_formats::config::{Config, SuConfig};
use potamoi_netlist::Module;
use potamoi_reference::splat_unit::{SplatEntry, SplatPixel, SplatSettings};
use potamoi_units::splat_unit::splat_unit;

use super::engine::EngineKind;
use super::model::RtlError;
use super::runner::Runner;
use super::wave_dump::{AFTER, Window};

pub(crate) use self::drive::Drive;

/// A splat unit, ready to run.
pub struct SplatUnit {
    runner: Runner,
    config: Config,
    su: SuConfig,
}

/// Results of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SplatRun {
    /// Pixels of every job, tile by tile and row by row.
    pub jobs: Vec<Vec<SplatPixel>>,
    /// Cycles before the first record: after the reset all pixels are cleared, and the limits are written.
    pub before: u64,
    /// Cycles from the first record to the last pixel.
    pub cycles: u64,
    /// Counters of the unit.
    pub counters: SplatCounters,
}

impl SplatUnit {
    /// The unit of a configuration on an engine.
    ///
    /// # Errors
    /// A missing or failing tool.
    pub fn on(engine: EngineKind, config: &Config, su: &SuConfig) -> Result<Self, RtlError> {
        Self::of_module(engine, config, su, &splat_unit(config, su)?)
    }

    /// A unit from another netlist with the same ports, such as a faulty one.
    ///
    /// # Errors
    /// As [`SplatUnit::on`].
    pub fn of_module(
        engine: EngineKind,
        config: &Config,
        su: &SuConfig,
        module: &Arc<Module>,
    ) -> Result<Self, RtlError> {
        Ok(Self {
            runner: Runner::new(engine, module)?,
            config: config.clone(),
            su: su.clone(),
        })
    }

    /// A unit from other Verilog files with the same ports, such as its gate-level netlist.
    ///
    /// # Errors
    /// As [`SplatUnit::on`]; the interpreter runs none.
    pub fn of_files(
        engine: EngineKind,
        config: &Config,
        su: &SuConfig,
        files: &BTreeMap<String, String>,
    ) -> Result<Self, RtlError> {
        Ok(Self {
            runner: Runner::of_files(engine, &splat_unit(config, su)?, files)?,
            config: config.clone(),
            su: su.clone(),
        })
    }

    /// Composites jobs, one after the other, of tiles 0 to `last_slot`, from reset, and holds every
    /// cycle to the cycle model: handshakes, pixels, `idle` and counters.
    ///
    /// # Errors
    /// [`RtlError::Mismatch`] at the first difference from the model; a unit that raises a flag or
    /// hangs.
    pub fn check(
        &self,
        jobs: &[&[SplatEntry]],
        last_slot: u16,
        settings: &SplatSettings,
        stalls: &Stalls,
        seed: u64,
    ) -> Result<SplatRun, RtlError> {
        let drive = Drive {
            config: &self.config,
            su: &self.su,
            jobs,
            last_slot,
            settings,
            plan: Plan::new(seed, stalls)?,
            after: 0,
        };
        self.runner.run(seed, drive)
    }

    /// Repeats a run that differs in `cycle`, and dumps the window around it. Returns the time of the
    /// cycle in the file.
    ///
    /// # Errors
    /// The file cannot be written, or the run does not differ.
    pub fn excerpt(
        &self,
        (jobs, last_slot, settings): (&[&[SplatEntry]], u16, &SplatSettings),
        (stalls, seed): (&Stalls, u64),
        cycle: u64,
        path: &Path,
    ) -> Result<u64, RtlError> {
        let drive = Drive {
            config: &self.config,
            su: &self.su,
            jobs,
            last_slot,
            settings,
            plan: Plan::new(seed, stalls)?,
            after: AFTER,
        };
        let window = Window::around(cycle, path);
        let time = window.time();
        match self.runner.run_dumped(seed, window, drive) {
            Err(RtlError::Mismatch(_)) => Ok(time),
            Err(other) => Err(other),
            Ok(_) => Err(RtlError::Usage("the run did not differ again".to_owned())),
        }
    }
}
