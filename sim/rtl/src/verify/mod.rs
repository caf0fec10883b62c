//! Verification of hardware against golden values and cycle models.
//!
//! A [`Verifier`] replaces a renderer's units. It computes with the reference units, sends the same
//! work through the hardware, and compares every bit and every cycle, without stalls and again
//! under random stalls, until the first difference. Both runs of a piece of work are made at once.

mod gather;
mod inject;
mod report;
mod splats;
mod vector;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use potamoi_base::files::{self, Unfinished};
use potamoi_cycles::{Stalls, StreamStalls};
use potamoi_formats::config::{Config, Sums};
use potamoi_formats::units::VectorOp;
use potamoi_reference::gathering_unit::ReferenceGatheringUnit;
use potamoi_reference::splat_unit::{Composited, ReferenceSplatUnit, SplatJob};
use potamoi_reference::vector_unit::ReferenceVectorUnit;
use potamoi_reference::{GatherTask, Product, UnitError, Units};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use schemars::JsonSchema;
use serde::Serialize;
use thiserror::Error;

use crate::{EngineKind, ForeignRtl, GatherUnit, Mismatch, RtlError, SplatUnit, VectorUnit};

pub use inject::Injection;
pub use report::{GatherReport, SplatReport, VectorReport};

/// Extent and conditions of a verification.
#[derive(Debug, Clone)]
pub struct Settings {
    /// Engine that runs the hardware.
    pub engine: EngineKind,
    /// Seed of the stalls.
    pub seed: u64,
    /// One of so many MVoxels is verified; at least 1.
    pub gather_every: u64,
    /// One of so many blocks of a vector operation is verified; at least 1.
    pub vector_every: u64,
    /// One of so many jobs of the splat unit is verified; at least 1.
    pub splat_every: u64,
    /// Fault to inject.
    pub inject: Option<Injection>,
    /// Verilog to verify instead of the emitted one.
    pub rtl: Option<ForeignRtl>,
    /// File for a dump of the window around a mismatch.
    pub excerpt: Option<PathBuf>,
}

/// A difference, with the conditions of its run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Failure {
    /// What differs.
    pub mismatch: Mismatch,
    /// Whether the run had random stalls.
    pub stalled: bool,
    /// Seed of the run's stalls, derived from the settings' seed.
    pub run_seed: u64,
    /// The dump, if requested and written.
    pub excerpt: Option<Excerpt>,
    /// Why the dump was not written.
    pub excerpt_error: Option<String>,
}

/// A dump of the window around a mismatch.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Excerpt {
    /// VCD file.
    pub path: PathBuf,
    /// Time of the mismatch's cycle in the file.
    pub time: u64,
}

/// Conditions of a run.
#[derive(Debug, Clone, Copy)]
struct Conditions {
    is_stalled: bool,
    stalls: Stalls,
    /// Seed of the stalls, and of state without reset.
    seed: u64,
}

impl Conditions {
    /// Makes both runs of a unit side by side: the first on this thread, which shows the progress of
    /// both, the second on another. The results are those of one run after the other, since each
    /// has an instance of the unit of its own.
    fn run_both<T: Send>(
        both: &[Self; 2],
        mut now: Progress,
        progress: &mut dyn FnMut(Progress),
        run: impl Fn(&Self, &mut dyn FnMut(u64)) -> Result<T, RtlError> + Sync,
    ) -> [Result<T, RtlError>; 2] {
        let [ready, stalled] = both;
        let (behind, mut other) = (AtomicU64::new(0), None);
        let own = rayon::in_place_scope(|scope| {
            scope.spawn(|_| {
                other = Some(run(stalled, &mut |more| {
                    behind.fetch_add(more, Ordering::Relaxed);
                }));
            });
            run(ready, &mut |more| {
                now.cycles += more + behind.swap(0, Ordering::Relaxed);
                progress(now);
            })
        });
        let other = other.unwrap_or_else(|| run(stalled, &mut |_| ()));
        [own, other]
    }
}

/// Error that stops the renderer at a difference.
#[derive(Debug, Error)]
#[error("{0}")]
struct Stopped(Mismatch);

/// Units that compute with the reference units and verify the hardware against them.
pub struct Verifier<'p> {
    config: Config,
    settings: Settings,
    gather_twin: ReferenceGatheringUnit,
    vector_twin: ReferenceVectorUnit,
    /// Of the settings of the last job.
    splat_twin: Option<ReferenceSplatUnit>,
    gather_unit: Option<GatherUnit>,
    vector_unit: Option<VectorUnit>,
    splat_unit: Option<SplatUnit>,
    gather: GatherReport,
    vector: VectorReport,
    splat: SplatReport,
    failure: Option<Failure>,
    /// Blocks of vectors seen.
    blocks: u64,
    progress: &'p mut dyn FnMut(Progress),
}

/// Progress of a verification.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Progress {
    /// Entries, elements and pixels of the splat unit so far, verified or skipped.
    pub done: u64,
    /// Cycles compared so far.
    pub cycles: u64,
}

impl<'p> Verifier<'p> {
    /// A verifier that builds each unit at its first call.
    #[must_use]
    pub fn new(config: &Config, settings: Settings, progress: &'p mut dyn FnMut(Progress)) -> Self {
        Self {
            config: config.clone(),
            settings,
            gather_twin: ReferenceGatheringUnit::new(config),
            vector_twin: ReferenceVectorUnit::new(&config.vu),
            splat_twin: None,
            gather_unit: None,
            vector_unit: None,
            splat_unit: None,
            gather: GatherReport::default(),
            vector: VectorReport::default(),
            splat: SplatReport::default(),
            failure: None,
            blocks: 0,
            progress,
        }
    }

    /// Counts of the gathering unit.
    #[must_use]
    pub const fn gather_report(&self) -> &GatherReport {
        &self.gather
    }

    /// Counts of the vector unit.
    #[must_use]
    pub const fn vector_report(&self) -> &VectorReport {
        &self.vector
    }

    /// Counts of the splat unit.
    #[must_use]
    pub const fn splat_report(&self) -> &SplatReport {
        &self.splat
    }

    /// The first difference, if there was one.
    #[must_use]
    pub const fn failure(&self) -> Option<&Failure> {
        self.failure.as_ref()
    }

    fn progress(&self) -> Progress {
        Progress {
            done: self.gather.samples_total + self.vector.elements_total + self.splat.pixels_total,
            cycles: self.gather.cycles_compared
                + self.vector.cycles_compared
                + self.splat.cycles_compared,
        }
    }

    fn show_progress(&mut self) {
        let progress = self.progress();
        (self.progress)(progress);
    }

    /// Conditions of the next two runs: without stalls, and under random stalls. Every run has a new
    /// seed.
    fn conditions(&self) -> [Conditions; 2] {
        let runs = self.gather.runs + self.vector.runs + self.splat.runs;
        let seed = |number: u64| self.settings.seed.wrapping_add(number);
        // The first of them counts as a run before the second.
        let (ready, stalled) = (seed(2 * runs), seed(2 * (runs + 1) + 1));
        let mut random = Pcg64Mcg::seed_from_u64(stalled);
        let mut stream = || StreamStalls {
            per_mille: random.random_range(0..500),
            burst: [1, 1, 2, 5][random.random_range(0..4)],
        };
        let stalls = Stalls {
            rit: stream(),
            mft: stream(),
            sink: stream(),
        };
        [
            Conditions {
                is_stalled: false,
                stalls: Stalls::NONE,
                seed: ready,
            },
            Conditions {
                is_stalled: true,
                stalls,
                seed: stalled,
            },
        ]
    }

    /// Dumps to a temporary name, then renames.
    fn excerpt(
        &self,
        dump: impl FnOnce(&Path) -> Result<u64, RtlError>,
    ) -> Option<Result<Excerpt, String>> {
        let path = self.settings.excerpt.clone()?;
        let cannot = |e: std::io::Error| {
            let path = path.display();
            format!("cannot write {path}: {e}; name a folder that can be written")
        };
        let dumped = || {
            let Some(place) = files::place(&path).map_err(cannot)? else {
                return dump(&path).map_err(|e| e.to_string());
            };
            let partial = Unfinished::beside(&place).map_err(cannot)?;
            let time = dump(partial.path()).map_err(|e| e.to_string())?;
            partial.finish().map_err(cannot)?;
            Ok(time)
        };
        Some(dumped().map(|time| Excerpt {
            path: path.clone(),
            time,
        }))
    }

    fn fail(
        &mut self,
        mismatch: Mismatch,
        stalled: bool,
        run_seed: u64,
        excerpt: Option<Result<Excerpt, String>>,
    ) -> RtlError {
        let (excerpt, excerpt_error) = match excerpt {
            Some(Ok(excerpt)) => (Some(excerpt), None),
            Some(Err(error)) => (None, Some(error)),
            None => (None, None),
        };
        self.failure = Some(Failure {
            mismatch: mismatch.clone(),
            stalled,
            run_seed,
            excerpt,
            excerpt_error,
        });
        RtlError::Mismatch(Box::new(mismatch))
    }

    fn stopped(&self) -> Result<(), UnitError> {
        match &self.failure {
            Some(failure) => Err(Box::new(Stopped(failure.mismatch.clone()))),
            None => Ok(()),
        }
    }
}

impl Units for Verifier<'_> {
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError> {
        if self.config.gu.sums == Sums::Exact {
            let mut sums = vec![];
            self.sums(tasks, &mut sums)?;
            let reducer = self.gather_twin.reducer();
            features.extend(sums.into_iter().map(|sum| reducer.round(sum.into())));
            return Ok(());
        }
        self.stopped()?;
        let begin = features.len();
        let mut flags = Vec::with_capacity(tasks.len());
        for task in tasks {
            flags.push(self.gather_twin.gather(task, features)?);
        }
        let codes: Vec<i32> = features[begin..]
            .iter()
            .map(|code| (*code).into())
            .collect();
        self.verify_gather(tasks, &codes, &flags)?;
        self.show_progress();
        Ok(())
    }

    fn sums(&mut self, tasks: &[GatherTask], sums: &mut Vec<i32>) -> Result<(), UnitError> {
        self.stopped()?;
        let begin = sums.len();
        let mut flags = Vec::with_capacity(tasks.len());
        for task in tasks {
            flags.push(self.gather_twin.sums(task, sums)?);
        }
        self.verify_gather(tasks, &sums[begin..], &flags)?;
        self.show_progress();
        Ok(())
    }

    fn vector(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), UnitError> {
        self.stopped()?;
        self.vector_twin.within(op.code, a, b)?;
        self.vector_twin.slice(op, a, b, out)?;
        self.verify_vector(op, a, b, out)?;
        self.show_progress();
        Ok(())
    }

    fn splats(&mut self, job: &SplatJob<'_>) -> Result<Composited, UnitError> {
        self.stopped()?;
        let own = self
            .splat_twin
            .take_if(|own| *own.settings() == job.settings);
        let exp = &self.config.vu.exp;
        let mut twin = own.unwrap_or_else(|| ReferenceSplatUnit::new(exp, 0, job.settings));
        let done = twin.run(job);
        self.splat_twin = Some(twin);
        self.verify_splats(job, &done)?;
        self.show_progress();
        Ok(done)
    }

    /// Computed in Rust: no unit does it.
    fn multiplied(&mut self, _product: Product) {}
}
