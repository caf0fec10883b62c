//! Drives the gathering unit on any engine.

use std::collections::BTreeMap;

use potamoi_cycles::{GatherInputs, GatherWork, Group, Plan, Stalls};
use potamoi_formats::config::Config;
use potamoi_reference::GatherTask;
use potamoi_units::gathering_unit::gathering_unit;

use super::engine::EngineKind;
use super::gather_drive::{Drive, GatherSeen, GatherTotals, GatherWatch};
use super::model::RtlError;
use super::port_trace::Traced;
use super::post_failure_window::PostFailureWindow;
use super::runner::Runner;
use super::wave_dump::Window;
use super::words::{code, slot};

/// Upper bound of the cycles that a dump continues after a failure.
const AFTER_FAILURE: u64 = 64;

/// A gathering unit, ready to run.
pub struct GatherUnit {
    config: Config,
    runner: Runner,
}

/// Results of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GatherRun {
    /// Features in task and entry order, all channels of an entry together. With `gu.sums =
    /// "exact"` unrounded sums, in units of 2^-W.
    pub features: Vec<i32>,
    /// Slot of every entry of every segment, in order of arrival.
    pub slots: Vec<u32>,
    /// Cycles and counters.
    pub totals: GatherTotals,
}

impl GatherUnit {
    /// The Verilated unit of a configuration, built or taken from the cache.
    ///
    /// # Errors
    /// A missing or failing tool.
    pub fn build(config: &Config) -> Result<Self, RtlError> {
        Self::on(EngineKind::Verilator, config)
    }

    /// The unit on an engine.
    ///
    /// # Errors
    /// As [`GatherUnit::build`].
    pub fn on(engine: EngineKind, config: &Config) -> Result<Self, RtlError> {
        Self::of_module(engine, config, &gathering_unit(config)?)
    }

    /// A unit from another netlist with the same ports, such as a faulty one.
    ///
    /// # Errors
    /// As [`GatherUnit::build`].
    pub fn of_module(
        engine: EngineKind,
        config: &Config,
        module: &std::sync::Arc<potamoi_netlist::Module>,
    ) -> Result<Self, RtlError> {
        Ok(Self {
            config: config.clone(),
            runner: Runner::new(engine, module)?,
        })
    }

    /// A unit from other Verilog files with the same ports, such as its gate-level netlist.
    ///
    /// # Errors
    /// As [`GatherUnit::build`]; the interpreter runs none.
    pub fn of_files(
        engine: EngineKind,
        config: &Config,
        files: &BTreeMap<String, String>,
    ) -> Result<Self, RtlError> {
        Ok(Self {
            config: config.clone(),
            runner: Runner::of_files(engine, &gathering_unit(config)?, files)?,
        })
    }

    /// Runs tasks through the unit, from reset.
    ///
    /// # Errors
    /// A malformed task, or a unit that hangs, fails, or returns beats that do not match the tasks.
    pub fn run(
        &self,
        tasks: &[GatherTask],
        stalls: &Stalls,
        seed: u64,
    ) -> Result<GatherRun, RtlError> {
        let work = GatherWork::new(&self.config, tasks)?;
        let mut collect = Collect::new(&work);
        let totals = self.watch(&work, stalls, seed, 0, &mut collect)?;
        Ok(GatherRun {
            features: collect.features,
            slots: collect.slots,
            totals,
        })
    }

    /// Values of the named inputs in every clock of a run, reset included: 32-bit words, input
    /// after input, clock after clock. Serves to measure other drivers of the Verilated unit with
    /// the same stimulus.
    ///
    /// # Errors
    /// As [`GatherUnit::run`].
    pub fn stimulus(
        &self,
        tasks: &[GatherTask],
        stalls: &Stalls,
        seed: u64,
        inputs: &[&str],
    ) -> Result<Vec<u32>, RtlError> {
        let work = GatherWork::new(&self.config, tasks)?;
        let mut collect = Collect::new(&work);
        let drive = self.drive(&work, stalls, seed, 0, &mut collect)?;
        self.runner.run_recorded(seed, inputs, drive)
    }

    /// Runs under an observer, and `drain` further cycles after the last beat.
    pub(super) fn watch(
        &self,
        work: &GatherWork<'_>,
        stalls: &Stalls,
        seed: u64,
        drain: u64,
        watch: &mut impl GatherWatch,
    ) -> Result<GatherTotals, RtlError> {
        let drive = self.drive(work, stalls, seed, drain, watch)?;
        self.runner.run(seed, drive)
    }

    /// As [`GatherUnit::watch`], with the ports recorded. State without reset is drawn from
    /// `state`, stalls from `seed`.
    pub(super) fn watch_traced(
        &self,
        work: &GatherWork<'_>,
        stalls: &Stalls,
        [seed, state]: [u64; 2],
        drain: u64,
        watch: &mut impl GatherWatch,
    ) -> Result<Traced<GatherTotals>, RtlError> {
        let drive = self.drive(work, stalls, seed, drain, watch)?;
        self.runner.run_traced(state, drive)
    }

    /// Repeats the run, and dumps a window of it. The observer's failure is returned some cycles
    /// late.
    pub(super) fn dump(
        &self,
        work: &GatherWork<'_>,
        stalls: &Stalls,
        seed: u64,
        drain: u64,
        watch: impl GatherWatch,
        window: Window,
    ) -> Result<GatherTotals, RtlError> {
        let mut watch = PostFailureWindow::new(watch);
        let drive = self.drive(work, stalls, seed, drain + AFTER_FAILURE, &mut watch)?;
        self.runner.run_dumped(seed, window, drive)
    }

    fn drive<'a, W: GatherWatch>(
        &'a self,
        work: &'a GatherWork<'a>,
        stalls: &Stalls,
        seed: u64,
        drain: u64,
        watch: &'a mut W,
    ) -> Result<Drive<'a, W>, RtlError> {
        work.run().check(&self.config)?;
        Ok(Drive {
            config: &self.config,
            work,
            plan: Plan::new(seed, stalls)?,
            drain,
            watch,
        })
    }
}

/// Collects the features of a run.
struct Collect<'a> {
    groups: Box<dyn Iterator<Item = Group> + 'a>,
    work: &'a GatherWork<'a>,
    features: Vec<i32>,
    slots: Vec<u32>,
}

impl<'a> Collect<'a> {
    fn new(work: &'a GatherWork<'a>) -> Self {
        Self {
            groups: Box::new(work.groups()),
            work,
            features: vec![0; work.entries() as usize * work.channels()],
            slots: Vec::with_capacity(work.entries() as usize * work.segments()),
        }
    }
}

impl GatherWatch for Collect<'_> {
    fn cycle(
        &mut self,
        _: u64,
        inputs: &GatherInputs,
        seen: &GatherSeen<'_>,
    ) -> Result<(), RtlError> {
        let Some(beat) = seen.beat.filter(|_| inputs.feat_ready) else {
            return Ok(());
        };
        let wrong = || RtlError::Usage("the unit gave other beats than the tasks have".to_owned());
        let group = self.groups.next().ok_or_else(wrong)?;
        let (width, channels) = (self.work.width(), self.work.channels());
        let low = group.low;
        let count = width.min(channels - low);
        for port in 0..group.kept {
            let first = self.work.lane_bytes() * width * port;
            if beat.keep[first / 32] >> (first % 32) & 1 == 0 {
                return Err(wrong());
            }
            if group.begins {
                self.slots
                    .push(slot(beat.user, port, self.work.slot_bits()));
            }
            let at = (group.ordinal + port) * channels + low;
            for (b, own) in self.features[at..at + count].iter_mut().enumerate() {
                *own = code(beat.data, port * width + b, self.work.lane_bytes());
            }
        }
        Ok(())
    }
}
