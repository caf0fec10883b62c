//! Cycles of the units by the effects that they are for.

use potamoi_cycles::{ClosedVector, GatherWork, runs};
use potamoi_formats::config::Config;
use potamoi_formats::units::VectorOp;
use potamoi_reference::{GatherTask, Product, UnitError, Units};
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

/// Units that count what other units do.
pub struct EffectMeter<'u> {
    units: &'u mut dyn Units,
    config: Config,
    /// From the first operation on.
    vector: Option<ClosedVector>,
    array: Array,
    cycles: EffectCycles,
}

impl<'u> EffectMeter<'u> {
    /// Of `units` of a configuration, beside the paper's MAC array.
    pub fn new(units: &'u mut dyn Units, config: &Config) -> Self {
        Self {
            units,
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

impl Units for EffectMeter<'_> {
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError> {
        self.count(tasks)?;
        self.units.gather(tasks, features)
    }

    fn sums(&mut self, tasks: &[GatherTask], sums: &mut Vec<i32>) -> Result<(), UnitError> {
        self.count(tasks)?;
        self.units.sums(tasks, sums)
    }

    fn vector(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), UnitError> {
        let vector = match &self.vector {
            Some(vector) => vector,
            None => self.vector.insert(ClosedVector::new(&self.config)?),
        };
        let found = vector.cycles(&[(op.code, a)]);
        self.cycles.vector += found.elapsed;
        if op.code.is_exponential() {
            self.cycles.exponentials += found.elapsed;
            self.cycles.powers += a.len() as u64;
        }
        self.units.vector(op, a, b, out)
    }

    fn multiplied(&mut self, product: Product) {
        self.cycles.array += self.array.cycles(&product);
        self.units.multiplied(product);
    }
}
