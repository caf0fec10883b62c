//! Verification of the vector unit.

use potamoi_cycles::vector_cycles;
use potamoi_formats::units::{VECTOR_UNIT, VectorOp};
use potamoi_units::vector_unit::vector_unit;

use super::{Conditions, Verifier};
use crate::{Check, Mismatch, RtlError, VectorBatch, VectorUnit};

/// Vectors in a block, the unit of sampling in a quick verification.
const BLOCK_VECTORS: usize = 4;

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
        let unit = match self.vector_unit.take() {
            Some(unit) => unit,
            None => self.build_vector()?,
        };
        let work: Vec<_> = batches.iter().map(|b| (b.op.code, b.a)).collect();
        let predicted = vector_cycles(&self.config, &work)?;
        let (both, now) = (self.conditions(), self.progress());
        let runs = Conditions::run_both(&both, now, &mut *self.progress, |conditions, progress| {
            let check = Check {
                stalls: conditions.stalls,
                seed: conditions.seed,
                flags: 0,
                progress,
            };
            unit.check(&self.config, batches, results, check)
        });
        for (conditions, totals) in both.into_iter().zip(runs) {
            let Conditions {
                is_stalled: stalled,
                stalls,
                seed,
            } = conditions;
            let totals = match totals {
                Ok(totals) => totals,
                Err(RtlError::Mismatch(mismatch)) => {
                    let excerpt = self.excerpt(|path| {
                        let check = Check {
                            stalls,
                            seed,
                            flags: 0,
                            progress: &mut |_| {},
                        };
                        unit.excerpt(&self.config, batches, results, check, mismatch.cycle, path)
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
            report.elements += results.len() as u64;
            report.vectors += totals.vectors;
            report.cycles += totals.cycles;
            report.cycles_predicted += predicted.elapsed;
            report.busy += totals.busy;
            report.stall_out += totals.stall_out;
        }
        self.vector_unit = Some(unit);
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
