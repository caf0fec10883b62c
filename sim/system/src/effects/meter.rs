//! Cycles of the units by the effects that they are for.

use potamoi_cycles::{ClosedVector, GatherWork, runs};
use potamoi_formats::config::Config;
use potamoi_reference::observer::{GatherCall, Observer, VectorCall};
use potamoi_reference::{GatherTask, Product, UnitError};
use serde::Serialize;

use crate::soc::npu::Array;

/// Cycles of a frame, by the cycle models that equal the RTL, streams always ready, each run and
/// each operation from reset.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize)]
pub struct EffectCycles {
    /// Of the gathering unit.
    pub gather: u64,
    /// Of them, those of entries of several vertices.
    pub interpolating: u64,
    /// Of them, issues of passes behind the first.
    pub further_passes: u64,
    /// Of the vector unit.
    pub vector: u64,
    /// Of them, those of exponentials and what is made of them.
    pub exponentials: u64,
    /// Of the MAC array.
    pub array: u64,
    /// RIT entries.
    pub entries: u64,
    /// Elements of exponentials and what is made of them.
    pub powers: u64,
}

/// Counts what units of a configuration do.
pub struct EffectMeter {
    config: Config,
    /// From the first operation on.
    vector: Option<ClosedVector>,
    array: Array,
    cycles: EffectCycles,
}

impl EffectMeter {
    /// Of units of a configuration, beside the paper's MAC array.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        Self {
            config: config.clone(),
            vector: None,
            array: Array::PAPER,
            cycles: EffectCycles::default(),
        }
    }

    /// So far.
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

    fn multiplied(&mut self, product: &Product) {
        self.cycles.array += self.array.cycles(product);
    }
}
