//! Verification of hardware against golden values and cycle models.
//!
//! A [`Verifier`] replaces a renderer's units. It computes with the reference units, sends the same
//! work through the hardware, and compares every bit and every cycle, without stalls and again
//! under random stalls, until the first difference. Runs are made on other threads while the
//! renderer goes on, and are looked at in the order of the work: seeds, counts and the first
//! difference are those of one run after the other.

mod gather;
mod inject;
mod reach;
mod report;
mod splats;
mod under_way;
mod vector;

use std::path::{Path, PathBuf};
use std::sync::Arc;

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

use crate::{Check, EngineKind, ForeignRtl, GatherUnit, Mismatch, RtlError, SplatUnit, VectorUnit};

use under_way::{Piece, Runs, UnderWay};

pub use inject::Injection;
pub use reach::GatherReach;
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
    /// A check under these conditions, with the flags that are expected at the end.
    fn check<'a>(&self, flags: u64, progress: &'a mut dyn FnMut(u64)) -> Check<'a> {
        Check {
            stalls: self.stalls,
            seed: self.seed,
            flags,
            progress,
        }
    }
}

/// Error that stops the renderer at a difference.
#[derive(Debug, Error)]
#[error("{0}")]
struct Stopped(Mismatch);

/// Units that compute with the reference units and verify the hardware against them.
pub struct Verifier<'p> {
    config: Arc<Config>,
    settings: Settings,
    gather_twin: ReferenceGatheringUnit,
    vector_twin: ReferenceVectorUnit,
    /// Of the settings of the last job.
    splat_twin: Option<ReferenceSplatUnit>,
    gather_unit: Option<Arc<GatherUnit>>,
    vector_unit: Option<Arc<VectorUnit>>,
    splat_unit: Option<Arc<SplatUnit>>,
    gather: GatherReport,
    vector: VectorReport,
    splat: SplatReport,
    failure: Option<Failure>,
    /// Blocks of vectors seen.
    blocks: u64,
    /// Pieces of work begun.
    pieces: u64,
    under_way: UnderWay,
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
            config: Arc::new(config.clone()),
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
            pieces: 0,
            under_way: UnderWay::default(),
            progress,
        }
    }

    /// Counts of the gathering unit, whole after [`Verifier::finish`] as those of the other units.
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

    /// The first difference, if there was one; known after [`Verifier::finish`].
    #[must_use]
    pub const fn failure(&self) -> Option<&Failure> {
        self.failure.as_ref()
    }

    fn progress(&self) -> Progress {
        Progress {
            done: self.gather.samples_total + self.vector.elements_total + self.splat.pixels_total,
            cycles: self.gather.cycles_compared
                + self.vector.cycles_compared
                + self.splat.cycles_compared
                + self.under_way.cycles(),
        }
    }

    fn show_progress(&mut self) {
        let progress = self.progress();
        (self.progress)(progress);
    }

    /// Waits for all runs, and compares them.
    ///
    /// # Errors
    /// A difference, or a unit or tool that fails.
    pub fn finish(&mut self) -> Result<(), RtlError> {
        if self.failure.is_some() {
            return Ok(());
        }
        while let Some(piece) = self.under_way.oldest() {
            self.compare(piece)?;
        }
        Ok(())
    }

    /// Leaves a piece of work to its threads, and compares the oldest if there are too many.
    fn add(&mut self, piece: Box<dyn Piece>) -> Result<(), RtlError> {
        self.under_way.push(piece);
        match self.under_way.overdue() {
            Some(piece) => self.compare(piece),
            None => Ok(()),
        }
    }

    fn compare(&mut self, piece: Box<dyn Piece>) -> Result<(), RtlError> {
        let compared = piece.compare(self);
        if compared.is_err() {
            self.under_way.clear();
        }
        compared
    }

    /// Waits for both runs of a piece.
    fn wait<T>(&mut self, runs: Runs<T>) -> [(Conditions, Result<T, RtlError>); 2] {
        let now = self.progress();
        runs.wait(|cycles| {
            (self.progress)(Progress {
                cycles: now.cycles + cycles,
                ..now
            });
        })
    }

    /// Conditions of the next two runs: without stalls, and under random stalls. Every run has a new
    /// seed.
    fn conditions(&mut self) -> [Conditions; 2] {
        let pieces = self.pieces;
        self.pieces += 1;
        let seed = |number: u64| self.settings.seed.wrapping_add(number);
        // The first of them counts as a run before the second.
        let (ready, stalled) = (seed(2 * pieces), seed(2 * (pieces + 1) + 1));
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
