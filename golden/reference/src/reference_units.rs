//! All reference units behind the [`Units`] trait, with counts of their work.

use std::collections::BTreeMap;

use potamoi_formats::config::{Config, NO_SPLAT_UNIT};
use potamoi_formats::units::{OpCode, VectorOp};
use thiserror::Error;

use super::gathering_unit::{GatherError, ReferenceGatheringUnit};
use super::splat_unit::{Composited, ReferenceSplatUnit, SplatJob, SplatUnitCounts};
use super::vector_unit::ReferenceVectorUnit;
use super::{GatherTask, Product, UnitError, Units};

/// Work that the units did.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct UnitCounts {
    /// Gathering tasks, one a MVoxel.
    pub gathers: u64,
    /// Entries gathered: feature vectors of all channels.
    pub feature_vectors: u64,
    /// Elements that each operation of the vector unit computed; unused operations are absent.
    pub elements: BTreeMap<OpCode, u64>,
    /// Jobs of the splat unit, one a ray group.
    pub splat_jobs: u64,
    /// Pixels that the splat unit returned, 256 a tile.
    pub splat_pixels: u64,
    /// Work of the splat unit.
    pub splats: SplatUnitCounts,
}

/// An error of one of several tasks.
#[derive(Debug, Error)]
#[error("task {index} of {count}: {source}")]
struct TaskError {
    index: usize,
    count: usize,
    source: GatherError,
}

/// The reference gathering unit, vector unit and splat unit.
#[derive(Debug, Clone)]
pub struct ReferenceUnits {
    config: Config,
    gather: ReferenceGatheringUnit,
    vector: ReferenceVectorUnit,
    /// Of the settings of the last job.
    splat: Option<ReferenceSplatUnit>,
    counts: UnitCounts,
    flags: u8,
}

impl ReferenceUnits {
    /// The units that `config` describes, which must have passed the rules of
    /// `potamoi_formats::config`.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        Self {
            config: config.clone(),
            splat: None,
            gather: ReferenceGatheringUnit::new(config),
            vector: ReferenceVectorUnit::new(&config.vu),
            counts: UnitCounts::default(),
            flags: 0,
        }
    }

    /// Work since construction.
    #[must_use]
    pub fn counts(&self) -> &UnitCounts {
        &self.counts
    }

    /// The gathering unit's sticky error flags: bits 0, 1, 2 and 6 of its `stat_errors`.
    #[must_use]
    pub fn gather_flags(&self) -> u8 {
        self.flags
    }

    /// The gathering unit.
    #[must_use]
    pub fn gather_twin(&self) -> &ReferenceGatheringUnit {
        &self.gather
    }

    /// The vector unit.
    #[must_use]
    pub fn vector_twin(&self) -> &ReferenceVectorUnit {
        &self.vector
    }
}

impl ReferenceUnits {
    /// Appends the results of `one` for every task, or nothing if any task is refused.
    fn each<T>(
        &mut self,
        tasks: &[GatherTask],
        out: &mut Vec<T>,
        one: impl Fn(&ReferenceGatheringUnit, &GatherTask, &mut Vec<T>) -> Result<u8, GatherError>,
    ) -> Result<(), UnitError> {
        let begin = out.len();
        let mut flags = 0;
        for (index, task) in tasks.iter().enumerate() {
            match one(&self.gather, task, out) {
                Ok(raised) => flags |= raised,
                Err(source) => {
                    out.truncate(begin);
                    let count = tasks.len();
                    return Err(Box::new(TaskError {
                        index,
                        count,
                        source,
                    }));
                }
            }
        }
        self.flags |= flags;
        self.counts.gathers += tasks.len() as u64;
        self.counts.feature_vectors += tasks.iter().map(|t| t.entries.len() as u64).sum::<u64>();
        Ok(())
    }
}

impl Units for ReferenceUnits {
    /// Nothing is appended if any task is refused.
    fn gather(&mut self, tasks: &[GatherTask], features: &mut Vec<i16>) -> Result<(), UnitError> {
        self.each(tasks, features, ReferenceGatheringUnit::gather)
    }

    fn sums(&mut self, tasks: &[GatherTask], sums: &mut Vec<i32>) -> Result<(), UnitError> {
        self.each(tasks, sums, ReferenceGatheringUnit::sums)
    }

    fn vector(
        &mut self,
        op: VectorOp,
        a: &[i32],
        b: &[i32],
        out: &mut [i32],
    ) -> Result<(), UnitError> {
        self.vector.within(op.code, a, b)?;
        self.vector.slice(op, a, b, out)?;
        *self.counts.elements.entry(op.code).or_default() += out.len() as u64;
        Ok(())
    }

    fn splats(&mut self, job: &SplatJob<'_>) -> Result<Composited, UnitError> {
        let su = self.config.su.as_ref().ok_or(NO_SPLAT_UNIT)?;
        if !(1..=su.tiles as usize).contains(&job.tiles) {
            return Err(format!(
                "a ray group of {} tiles: expected 1 to {}, which the splat unit holds (su.tiles)",
                job.tiles, su.tiles
            )
            .into());
        }
        let own = self.splat.take_if(|own| *own.settings() == job.settings);
        let mut unit =
            own.unwrap_or_else(|| ReferenceSplatUnit::new(&self.config.vu.exp, 0, job.settings));
        let done = unit.run(job);
        self.splat = Some(unit);
        self.counts.splat_jobs += 1;
        self.counts.splat_pixels += done.pixels.len() as u64;
        self.counts.splats += done.counts;
        Ok(done)
    }

    /// Not counted.
    fn multiplied(&mut self, _product: Product) {}
}
