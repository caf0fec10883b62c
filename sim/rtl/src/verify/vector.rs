//! Verification of the vector unit.

use std::sync::Arc;

use potamoi_cycles::vector_cycles;
use potamoi_formats::config::Config;
use potamoi_formats::units::{VECTOR_UNIT, VectorOp};
use potamoi_units::vector_unit::vector_unit;

use super::under_way::{Piece, Runs, UnderWay};
use super::{Conditions, Verifier};
use crate::vector_drive::VectorTotals;
use crate::{Mismatch, RtlError, VectorBatch, VectorUnit};

/// Vectors in a block, the unit of sampling in a quick verification.
const BLOCK_VECTORS: usize = 4;

/// A batch with its operands.
struct Batch {
    op: VectorOp,
    a: Vec<i32>,
    b: Vec<i32>,
}

/// Batches, and the results of the reference unit.
struct VectorWork {
    unit: Arc<VectorUnit>,
    config: Arc<Config>,
    batches: Vec<Batch>,
    results: Vec<i32>,
}

/// Batches under way.
struct VectorPiece {
    work: Arc<VectorWork>,
    runs: Runs<VectorTotals>,
}

impl VectorWork {
    fn batches(&self) -> Vec<VectorBatch<'_>> {
        let each = self
            .batches
            .iter()
            .map(|Batch { op, a, b }| VectorBatch { op: *op, a, b });
        each.collect()
    }

    fn run(
        &self,
        conditions: &Conditions,
        progress: &mut dyn FnMut(u64),
    ) -> Result<VectorTotals, RtlError> {
        let check = conditions.check(0, progress);
        self.unit
            .check(&self.config, &self.batches(), &self.results, check)
    }
}

impl Piece for VectorPiece {
    fn cycles(&self) -> u64 {
        self.runs.cycles()
    }

    fn compare(self: Box<Self>, verifier: &mut Verifier<'_>) -> Result<(), RtlError> {
        verifier.compare_vector(*self)
    }
}

impl Verifier<'_> {
    /// Verifies the share of the elements in the settings. `results` are the reference unit's.
    pub(super) fn verify_vector(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        results: &[i32],
    ) -> Result<(), RtlError> {
        let block = BLOCK_VECTORS * self.config.vu.lanes.max(1) as usize;
        let every = self.settings.vector_every.max(1);
        self.vector.elements_total += a.len() as u64;
        let (mut batches, mut picked) = (vec![], vec![]);
        if every == 1 {
            batches.push(VectorBatch { op, a, b });
            picked.extend_from_slice(results);
        } else {
            let parts = a
                .chunks(block)
                .zip(b.chunks(block))
                .zip(results.chunks(block));
            for ((a, b), results) in parts {
                if self.blocks.is_multiple_of(every) {
                    batches.push(VectorBatch { op, a, b });
                    picked.extend_from_slice(results);
                }
                self.blocks += 1;
            }
        }
        if picked.is_empty() {
            return Ok(());
        }
        self.vector_run(&batches, &picked)
    }

    fn vector_run(&mut self, batches: &[VectorBatch<'_>], results: &[i32]) -> Result<(), RtlError> {
        let unit = match &self.vector_unit {
            Some(unit) => unit.clone(),
            None => Arc::new(self.build_vector()?),
        };
        self.vector_unit = Some(unit.clone());
        let names = batches.iter().map(|batch| batch.op.code.name());
        self.vector.operations.extend(names);
        let own = |batch: &VectorBatch<'_>| Batch {
            op: batch.op,
            a: batch.a.to_vec(),
            b: batch.b.to_vec(),
        };
        let work = Arc::new(VectorWork {
            unit,
            config: self.config.clone(),
            batches: batches.iter().map(own).collect(),
            results: results.to_vec(),
        });
        let conditions = self.conditions();
        let runs = UnderWay::begin(conditions, {
            let work = work.clone();
            move |conditions, progress| work.run(conditions, progress)
        });
        self.add(Box::new(VectorPiece { work, runs }))
    }

    /// Compares both runs of a piece of work.
    fn compare_vector(&mut self, piece: VectorPiece) -> Result<(), RtlError> {
        let VectorPiece { work, runs } = piece;
        let batches = work.batches();
        let operands: Vec<_> = batches.iter().map(|b| (b.op.code, b.a)).collect();
        let predicted = vector_cycles(&self.config, &operands)?;
        for (conditions, totals) in self.wait(runs) {
            let (stalled, seed) = (conditions.is_stalled, conditions.seed);
            let totals = match totals {
                Ok(totals) => totals,
                Err(RtlError::Mismatch(mismatch)) => {
                    let excerpt = self.excerpt(|path| {
                        let none = &mut |_| {};
                        let check = conditions.check(0, none);
                        let VectorWork { unit, config, .. } = &*work;
                        unit.excerpt(config, &batches, &work.results, check, mismatch.cycle, path)
                    });
                    return Err(self.fail(*mismatch, stalled, seed, excerpt));
                }
                Err(other) => return Err(other),
            };
            let report = &mut self.vector;
            report.cycles_compared += totals.cycles;
            if stalled {
                report.cycles_stalled += totals.cycles;
                continue;
            }
            if totals.cycles != predicted.elapsed {
                let mismatch = Mismatch {
                    module: VECTOR_UNIT,
                    cycle: totals.cycles,
                    signal: "cycles from the first vector to the last result".to_owned(),
                    expected: predicted.elapsed.to_string(),
                    found: totals.cycles.to_string(),
                    place: format!("whole run of {} batches, closed form", batches.len()),
                };
                return Err(self.fail(mismatch, stalled, seed, None));
            }
            report.runs += 1;
            report.elements += work.results.len() as u64;
            report.vectors += totals.vectors;
            report.cycles += totals.cycles;
            report.cycles_predicted += predicted.elapsed;
            report.busy += totals.busy;
            report.stall_out += totals.stall_out;
        }
        Ok(())
    }

    fn build_vector(&self) -> Result<VectorUnit, RtlError> {
        let mut module = vector_unit(&self.config)?;
        if let Some(rtl) = &self.settings.rtl {
            let files = rtl.files(&module)?;
            return VectorUnit::of_files(self.settings.engine, &self.config, &files);
        }
        if let Some(injection) = self.settings.inject.filter(|i| i.is_of_vector_unit()) {
            module = injection.apply(&self.config, &module)?;
        }
        VectorUnit::of_module(self.settings.engine, &self.config, &module)
    }
}
