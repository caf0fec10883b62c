//! Verification of the splat unit.

use std::sync::Arc;

use potamoi_formats::config::NO_SPLAT_UNIT;
use potamoi_formats::units::SPLAT_UNIT;
use potamoi_reference::splat_unit::{Composited, SplatEntry, SplatJob, SplatSettings, TILE_PIXELS};
use potamoi_units::splat_unit::splat_unit;

use super::under_way::{Piece, Runs, UnderWay};
use super::{Conditions, Verifier};
use crate::{Mismatch, RtlError, SplatRun, SplatUnit};

/// A job, and what the reference unit makes of it.
struct SplatWork {
    unit: Arc<SplatUnit>,
    number: u64,
    settings: SplatSettings,
    /// The last slot.
    last: u16,
    entries: Vec<SplatEntry>,
    done: Composited,
}

/// A job under way.
struct SplatPiece {
    work: Arc<SplatWork>,
    runs: Runs<SplatRun>,
}

impl SplatWork {
    fn run(&self, conditions: &Conditions) -> Result<SplatRun, RtlError> {
        let Conditions { stalls, seed, .. } = conditions;
        let jobs = [&self.entries[..]];
        self.unit
            .check(&jobs, self.last, &self.settings, stalls, *seed)
    }
}

impl Piece for SplatPiece {
    fn cycles(&self) -> u64 {
        self.runs.cycles()
    }

    fn compare(self: Box<Self>, verifier: &mut Verifier<'_>) -> Result<(), RtlError> {
        verifier.compare_splats(*self)
    }
}

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
        let unit = match &self.splat_unit {
            Some(unit) => unit.clone(),
            None => Arc::new(self.build_splat()?),
        };
        self.splat_unit = Some(unit.clone());
        let work = Arc::new(SplatWork {
            unit,
            number,
            settings: job.settings,
            last: u16::try_from(job.tiles.saturating_sub(1)).unwrap_or(u16::MAX),
            entries: job.entries.to_vec(),
            done: done.clone(),
        });
        let conditions = self.conditions();
        let runs = UnderWay::begin(conditions, {
            let work = work.clone();
            move |conditions, _| work.run(conditions)
        });
        self.add(Box::new(SplatPiece { work, runs }))
    }

    /// Compares both runs of a piece of work.
    fn compare_splats(&mut self, piece: SplatPiece) -> Result<(), RtlError> {
        let SplatPiece { work, runs } = piece;
        let done = &work.done;
        for (conditions, run) in self.wait(runs) {
            let Conditions {
                is_stalled: stalled,
                stalls,
                seed,
            } = conditions;
            let run = match run {
                Ok(run) => run,
                Err(RtlError::Mismatch(mismatch)) => {
                    let excerpt = self.excerpt(|path| {
                        let entries = [&work.entries[..]];
                        let own = (&entries[..], work.last, &work.settings);
                        work.unit
                            .excerpt(own, (&stalls, seed), mismatch.cycle, path)
                    });
                    return Err(self.fail(*mismatch, stalled, seed, excerpt));
                }
                Err(other) => return Err(other),
            };
            if let Some(mismatch) = differing(work.number, &run, done) {
                return Err(self.fail(mismatch, stalled, seed, None));
            }
            let report = &mut self.splat;
            report.cycles_compared += run.before + run.cycles;
            if stalled {
                report.cycles_stalled += run.before + run.cycles;
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
