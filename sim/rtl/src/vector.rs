//! Drives the vector unit on any engine.

use std::collections::BTreeMap;

use potamoi_cycles::{Exponents, Plan, Stalls, VectorInputs};
use potamoi_formats::config::Config;
use potamoi_units::vector_unit::vector_unit;

use super::engine::EngineKind;
use super::model::RtlError;
use super::port_trace::Traced;
use super::post_failure_window::PostFailureWindow;
use super::runner::Runner;
use super::vector_drive::{Drive, VectorBatch, VectorSeen, VectorTotals, VectorWatch, Vectors};
use super::wave_dump::Window;

/// Upper bound of the cycles that a dump continues after a failure.
const AFTER_FAILURE: u64 = 64;

/// A vector unit, ready to run.
pub struct VectorUnit {
    lanes: usize,
    exponents: Exponents,
    runner: Runner,
}

/// Results of a run.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct VectorRun {
    /// Results, one an element.
    pub results: Vec<i32>,
    /// For each vector the cycles in which it and its results were accepted.
    pub vectors: Vec<(u64, u64)>,
    /// Cycles and counters.
    pub totals: VectorTotals,
}

impl VectorUnit {
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
    /// As [`VectorUnit::build`].
    pub fn on(engine: EngineKind, config: &Config) -> Result<Self, RtlError> {
        Self::of_module(engine, config, &vector_unit(config)?)
    }

    /// A unit from another netlist with the same ports, such as a faulty one.
    ///
    /// # Errors
    /// As [`VectorUnit::build`].
    pub fn of_module(
        engine: EngineKind,
        config: &Config,
        module: &std::sync::Arc<potamoi_netlist::Module>,
    ) -> Result<Self, RtlError> {
        Ok(Self {
            lanes: config.vu.lanes as usize,
            exponents: Exponents::of(config),
            runner: Runner::new(engine, module)?,
        })
    }

    /// A unit from other Verilog files with the same ports, such as its gate-level netlist.
    ///
    /// # Errors
    /// As [`VectorUnit::build`]; the interpreter runs none.
    pub fn of_files(
        engine: EngineKind,
        config: &Config,
        files: &BTreeMap<String, String>,
    ) -> Result<Self, RtlError> {
        Ok(Self {
            lanes: config.vu.lanes as usize,
            exponents: Exponents::of(config),
            runner: Runner::of_files(engine, &vector_unit(config)?, files)?,
        })
    }

    /// The vectors of these batches.
    pub(super) fn vectors<'a>(&self, batches: &[VectorBatch<'a>]) -> Result<Vectors<'a>, RtlError> {
        Vectors::new(batches, self.lanes, &self.exponents)
    }

    /// Computes element by element, from reset.
    ///
    /// # Errors
    /// Operands of different lengths, or a unit that hangs or fails.
    pub fn run(
        &self,
        batches: &[VectorBatch<'_>],
        stalls: &Stalls,
        seed: u64,
    ) -> Result<VectorRun, RtlError> {
        let vectors = self.vectors(batches)?;
        let mut collect = Collect::new(&vectors);
        let totals = self.watch(&vectors, stalls, seed, 0, &mut collect)?;
        Ok(VectorRun {
            results: collect.results,
            vectors: collect.times,
            totals,
        })
    }

    /// Values of the named inputs in every clock of a run, reset included: 32-bit words, input
    /// after input, clock after clock. Serves to measure other drivers of the Verilated unit with
    /// the same stimulus.
    ///
    /// # Errors
    /// As [`VectorUnit::run`].
    pub fn stimulus(
        &self,
        batches: &[VectorBatch<'_>],
        stalls: &Stalls,
        seed: u64,
        inputs: &[&str],
    ) -> Result<Vec<u32>, RtlError> {
        let vectors = self.vectors(batches)?;
        let drive = Drive {
            vectors: &vectors,
            plan: Plan::new(seed, stalls)?,
            drain: 0,
            watch: &mut Collect::new(&vectors),
        };
        self.runner.run_recorded(seed, inputs, drive)
    }

    /// Runs under an observer, and `drain` further cycles after the last results.
    pub(super) fn watch(
        &self,
        vectors: &Vectors<'_>,
        stalls: &Stalls,
        seed: u64,
        drain: u64,
        watch: &mut impl VectorWatch,
    ) -> Result<VectorTotals, RtlError> {
        let drive = Drive {
            vectors,
            plan: Plan::new(seed, stalls)?,
            drain,
            watch,
        };
        self.runner.run(seed, drive)
    }

    /// As [`VectorUnit::watch`], with the ports recorded. State without reset is drawn from
    /// `state`, stalls from `seed`.
    pub(super) fn watch_traced(
        &self,
        vectors: &Vectors<'_>,
        stalls: &Stalls,
        [seed, state]: [u64; 2],
        drain: u64,
        watch: &mut impl VectorWatch,
    ) -> Result<Traced<VectorTotals>, RtlError> {
        let drive = Drive {
            vectors,
            plan: Plan::new(seed, stalls)?,
            drain,
            watch,
        };
        self.runner.run_traced(state, drive)
    }

    /// Repeats the run, and dumps a window of it. The observer's failure is returned some cycles
    /// late.
    pub(super) fn dump(
        &self,
        vectors: &Vectors<'_>,
        stalls: &Stalls,
        seed: u64,
        drain: u64,
        watch: impl VectorWatch,
        window: Window,
    ) -> Result<VectorTotals, RtlError> {
        let drive = Drive {
            vectors,
            plan: Plan::new(seed, stalls)?,
            drain: drain + AFTER_FAILURE,
            watch: &mut PostFailureWindow::new(watch),
        };
        self.runner.run_dumped(seed, window, drive)
    }
}

/// Collects the results of a run.
struct Collect<'a> {
    vectors: &'a Vectors<'a>,
    results: Vec<i32>,
    times: Vec<(u64, u64)>,
    taken: usize,
}

impl<'a> Collect<'a> {
    fn new(vectors: &'a Vectors<'a>) -> Self {
        Self {
            vectors,
            results: Vec::with_capacity(vectors.elements()),
            times: Vec::with_capacity(vectors.list.len()),
            taken: 0,
        }
    }
}

impl VectorWatch for Collect<'_> {
    fn cycle(
        &mut self,
        cycle: u64,
        inputs: &VectorInputs,
        seen: &VectorSeen<'_>,
    ) -> Result<(), RtlError> {
        if let Some(result) = seen.result.filter(|_| inputs.ready) {
            let wrong = || RtlError::Usage("the unit gave more vectors than it got".to_owned());
            let vector = self.vectors.list.get(self.taken).ok_or_else(wrong)?;
            let results = &result.data[..vector.a.len()];
            self.results.extend(results.iter().map(|w| *w as i32));
            self.times.get_mut(self.taken).ok_or_else(wrong)?.1 = cycle;
            self.taken += 1;
        }
        if inputs.op.is_some() && seen.ready {
            self.times.push((cycle, 0));
        }
        Ok(())
    }
}
