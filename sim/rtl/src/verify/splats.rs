//! Verification of the splat unit.

use potamoi_formats::config::NO_SPLAT_UNIT;
use potamoi_formats::units::SPLAT_UNIT;
use potamoi_reference::splat_unit::{Composited, SplatJob, TILE_PIXELS};
use potamoi_units::splat_unit::splat_unit;

use super::{Conditions, Verifier};
use crate::{Mismatch, RtlError, SplatRun, SplatUnit};

impl Verifier<'_> {
    /// Verifies a job, if it is one of the share in the settings. `done` is the reference unit's.
    pub(super) fn verify_splats(
        &mut self,
        job: &SplatJob<'_>,
        done: &Composited,
    ) -> Result<(), RtlError> {
        let number = self.splat.jobs_total;
        self.splat.jobs_total += 1;
        self.splat.pixels_total += done.pixels.len() as u64;
        if !number.is_multiple_of(self.settings.splat_every.max(1)) {
            return Ok(());
        }
        let unit = match self.splat_unit.take() {
            Some(unit) => unit,
            None => self.build_splat()?,
        };
        let last = u16::try_from(job.tiles.saturating_sub(1)).unwrap_or(u16::MAX);
        let (both, now) = (self.conditions(), self.progress());
        let runs = Conditions::run_both(&both, now, &mut *self.progress, |conditions, _| {
            let Conditions { stalls, seed, .. } = conditions;
            unit.check(&[job.entries], last, &job.settings, stalls, *seed)
        });
        for (conditions, run) in both.into_iter().zip(runs) {
            let Conditions {
                is_stalled: stalled,
                stalls,
                seed,
            } = conditions;
            let run = match run {
                Ok(run) => run,
                Err(RtlError::Mismatch(mismatch)) => {
                    let excerpt = self.excerpt(|path| {
                        let work = (&[job.entries][..], last, &job.settings);
                        unit.excerpt(work, (&stalls, seed), mismatch.cycle, path)
                    });
                    return Err(self.fail(*mismatch, stalled, seed, excerpt));
                }
                Err(other) => return Err(other),
            };
            if let Some(mismatch) = differing(number, &run, done) {
                return Err(self.fail(mismatch, stalled, seed, None));
            }
            let report = &mut self.splat;
            report.cycles_compared += run.cycles;
            if stalled {
                report.cycles_stalled += run.cycles;
                continue;
            }
            report.runs += 1;
            report.jobs += 1;
            report.pixels += done.pixels.len() as u64;
            report.records += run.counters.records;
            report.square_sums += run.counters.square_sums;
            report.exponentials += run.counters.exponentials;
            report.drawn += run.counters.drawn;
            report.stopped += run.counters.stopped;
            report.cycles += run.cycles;
            report.busy += run.counters.busy;
        }
        self.splat_unit = Some(unit);
        Ok(())
    }

    fn build_splat(&self) -> Result<SplatUnit, RtlError> {
        let su = self.config.su.as_ref();
        let su = su.ok_or_else(|| RtlError::Usage(NO_SPLAT_UNIT.to_owned()))?;
        let mut module = splat_unit(&self.config, su)?;
        if let Some(rtl) = &self.settings.rtl {
            let files = rtl.files(&module)?;
            return SplatUnit::of_files(self.settings.engine, &self.config, su, &files);
        }
        if let Some(injection) = self.settings.inject.filter(|i| i.is_of_splat_unit()) {
            module = injection.apply(&self.config, &module)?;
        }
        SplatUnit::of_module(self.settings.engine, &self.config, su, &module)
    }
}

/// The first pixel that is not the reference unit's.
fn differing(number: u64, run: &SplatRun, done: &Composited) -> Option<Mismatch> {
    let found = run.jobs.first()?;
    let at = found.iter().zip(&done.pixels).position(|(a, b)| a != b)?;
    let (tile, pixel) = (at / TILE_PIXELS, at % TILE_PIXELS);
    Some(Mismatch {
        module: SPLAT_UNIT,
        cycle: run.cycles,
        signal: "m_axis_pix".to_owned(),
        expected: format!("{:?}", done.pixels[at]),
        found: format!("{:?}", found[at]),
        place: format!(
            "job {number}, tile {tile}, column {} of row {}, reference unit",
            pixel % 16,
            pixel / 16
        ),
    })
}
