//! Cycles of the units by rendering effect.

use super::{ClosedVector, GatherWork, runs};
use potamoi_formats::config::{Config, NO_SPLAT_UNIT};
use potamoi_reference::observer::{GatherCall, Observer, SplatCall, VectorCall};
use potamoi_reference::{GatherTask, Product, UnitError};
use schemars::JsonSchema;
use serde::Serialize;

use super::mac_array::MacArray;
use super::splat_unit::SplatRunner;

/// Cycles of a frame. The cycle models count them, which equal the RTL with streams always ready;
/// each run and each operation starts from reset.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, JsonSchema)]
pub struct EffectCycles {
    /// Cycles of the gathering unit.
    pub gather: u64,
    /// Gathering cycles of entries with more than one vertex.
    pub interpolating: u64,
    /// Gathering cycles of issues of further passes (all but the first).
    pub further_passes: u64,
    /// Cycles of the vector unit.
    pub vector: u64,
    /// Vector cycles of exponentials and of operations on their results.
    pub exponentials: u64,
    /// Cycles of the MAC array.
    pub array: u64,
    /// RIT entries.
    pub entries: u64,
    /// Elements of exponentials and of operations on their results.
    pub powers: u64,
    /// Cycles of splat units, all jobs one after the other.
    pub splats: u64,
}

/// Counts cycles by effect while a frame is rendered.
pub struct EffectMeter {
    config: Config,
    /// Set with the first operation.
    vector: Option<ClosedVector>,
    array: MacArray,
    splats: Option<SplatRunner>,
    cycles: EffectCycles,
}

impl EffectMeter {
    /// A meter for units of `config` and the paper's MAC array.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        Self {
            config: config.clone(),
            vector: None,
            array: MacArray::PAPER,
            splats: SplatRunner::new(config),
            cycles: EffectCycles::default(),
        }
    }

    /// Cycles counted so far.
    #[must_use]
    pub const fn cycles(&self) -> EffectCycles {
        self.cycles
    }

    fn count(&mut self, tasks: &[GatherTask]) -> Result<(), UnitError> {
        for tasks in runs(tasks) {
            let work = GatherWork::new(&self.config, tasks)?;
            let found = work.predicted(&self.config)?;
            let own = &mut self.cycles;
            own.gather += found.elapsed;
            own.entries += tasks.iter().map(|t| t.entries.len() as u64).sum::<u64>();
            if tasks[0].vertices.is_structured() {
                own.interpolating += found.elapsed;
            }
            let segments = u64::from(work.run().segments).max(1);
            own.further_passes += found.busy / segments * (segments - 1);
        }
        Ok(())
    }
}

impl Observer for EffectMeter {
    fn gathered(&mut self, call: &GatherCall<'_>) -> Result<(), UnitError> {
        self.count(call.tasks)
    }

    fn computed(&mut self, call: &VectorCall<'_>) -> Result<(), UnitError> {
        let vector = match &self.vector {
            Some(vector) => vector,
            None => self.vector.insert(ClosedVector::new(&self.config)?),
        };
        let found = vector.cycles(&[(call.op.code, call.a)]);
        self.cycles.vector += found.elapsed;
        if call.op.code.is_exponential() {
            self.cycles.exponentials += found.elapsed;
            self.cycles.powers += call.a.len() as u64;
        }
        Ok(())
    }

    fn composited(&mut self, call: &SplatCall<'_>) -> Result<(), UnitError> {
        let unit = self.splats.as_mut().ok_or(NO_SPLAT_UNIT)?;
        let run = unit.run(call.job)?;
        self.cycles.splats += run.cycles;
        self.cycles.powers += run.counters.exponentials;
        Ok(())
    }

    fn multiplied(&mut self, product: &Product) {
        self.cycles.array += self.array.cycles(product);
    }
}
