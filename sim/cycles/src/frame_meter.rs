//! Work of the units for a frame, measured call by call.

use std::time::{Duration, Instant};

use super::batch::{Batch, BatchEvents};
use super::splat_unit::{SplatRunner, last_end};
use super::{ClosedVector, GatherWork, runs};
use potamoi_formats::config::{Config, NO_SPLAT_UNIT, RitPath};
use potamoi_reference::observer::{GatherCall, Observer, SplatCall, VectorCall};
use potamoi_reference::{GatherTask, Product, UnitError};

/// Bytes of a feature code or an activation.
const CODE: u64 = 2;

/// Observer that counts the work of units of a configuration. Cycle models of the same runs give
/// the cycles.
pub struct FrameMeter {
    config: Config,
    /// Where lengths of operations depend on operands; set with the first operation.
    vector: Option<ClosedVector>,
    batches: Vec<BatchEvents>,
    is_computing: bool,
    splats: Option<SplatRunner>,
    /// Batch and cycles of each job of splat units, in order.
    splat_jobs: Vec<(usize, u64)>,
    sums: GatherSums,
    /// Wall time of the cycle models.
    modelled: Duration,
}

/// Gathering cycles by closed form over MVoxels, without simulation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct GatherSums {
    /// Cycles of vertex reads; as many entries are read at once as there are ports.
    pub reads: u64,
    /// Cycles of loading rows into the MFT, one row a cycle.
    pub loads: u64,
}

impl GatherSums {
    /// Cycles with a double-buffered MFT: the larger of reads and loads.
    #[must_use]
    pub fn cycles(self) -> u64 {
        self.reads.max(self.loads)
    }
}

impl FrameMeter {
    /// A meter for units of `config`.
    #[must_use]
    pub fn new(config: &Config) -> Self {
        Self {
            config: config.clone(),
            vector: None,
            batches: vec![BatchEvents::default()],
            is_computing: false,
            splats: SplatRunner::new(config),
            splat_jobs: vec![],
            sums: GatherSums::default(),
            modelled: Duration::ZERO,
        }
    }

    /// Gathering cycles by closed form.
    #[must_use]
    pub const fn sums(&self) -> GatherSums {
        self.sums
    }

    /// Wall time of the cycle models.
    #[must_use]
    pub const fn modelled(&self) -> Duration {
        self.modelled
    }

    /// The batches, in order.
    #[must_use]
    pub fn into_events(mut self) -> Vec<BatchEvents> {
        self.place_splat_jobs();
        self.batches
            .into_iter()
            .filter(BatchEvents::is_some)
            .collect()
    }

    /// Gives each batch its part of the time in which the units side by side do all jobs, in
    /// proportion to the cycles of its own.
    fn place_splat_jobs(&mut self) {
        let units = self.config.su.as_ref().map_or(1, |su| su.units);
        let all: u64 = self.splat_jobs.iter().map(|(_, cycles)| cycles).sum();
        let end = last_end(self.splat_jobs.iter().map(|(_, cycles)| *cycles), units);
        let upto = |done: u64| (u128::from(done) * u128::from(end) / u128::from(all.max(1))) as u64;
        let mut done = 0;
        for (batch, cycles) in &self.splat_jobs {
            self.batches[*batch].gathered.splat_elapsed += upto(done + cycles) - upto(done);
            done += cycles;
        }
    }

    fn batch(&mut self) -> &mut BatchEvents {
        if self.batches.is_empty() {
            self.batches.push(BatchEvents::default());
        }
        let last = self.batches.len() - 1;
        &mut self.batches[last]
    }

    fn count(&mut self, tasks: &[GatherTask]) -> Result<(), UnitError> {
        if std::mem::take(&mut self.is_computing) {
            self.batches.push(BatchEvents::default());
        }
        for run in runs(tasks) {
            let begun = Instant::now();
            let work = GatherWork::new(&self.config, run)?;
            let own = counted(run, &work, &self.config)?;
            self.modelled += begun.elapsed();
            self.batch().gathered += own;
            let set = work.run();
            let groups = |entries: usize| entries.div_ceil(self.config.gu.ports as usize) as u64;
            for (task, mvoxel) in run.iter().zip(set.mvoxels) {
                let passes = u64::from(set.segments);
                let vertices = task.vertices.count() as u64;
                self.sums.reads += groups(task.entries.len()) * vertices * passes;
                self.sums.loads += u64::from(mvoxel.rows) * passes;
            }
        }
        Ok(())
    }
}

/// Counts a run of the gathering unit over consecutive tasks.
fn counted(
    tasks: &[GatherTask],
    work: &GatherWork<'_>,
    config: &Config,
) -> Result<Batch, UnitError> {
    let cycles = work.predicted(config)?;
    let mut own = Batch {
        runs: 1,
        gather_cycles: cycles.elapsed,
        gather_busy: cycles.busy,
        ..Batch::default()
    };
    let run = work.run();
    for (task, mvoxel) in tasks.iter().zip(run.mvoxels) {
        let entries = task.entries.len() as u64;
        let bytes = match config.rit.path {
            RitPath::Dram => entries * config.entry_bytes(task.vertices) as u64,
            RitPath::Direct => 0,
        };
        let times = match run.streamed_again(config, *mvoxel) {
            true => u64::from(run.segments),
            false => 1,
        };
        let channels = task.channels as u64;
        own += Batch {
            mvoxels: 1,
            entries,
            codes_read: entries * task.vertices.count() as u64 * channels,
            row_bytes: task.rows.len() as u64 * CODE,
            rit_bytes: bytes,
            rit_read_bytes: bytes * times,
            feature_bytes: entries * channels * u64::from(config.feature_lane_bits()) / 8,
            ..Batch::default()
        };
    }
    Ok(own)
}

impl Observer for FrameMeter {
    fn gathered(&mut self, call: &GatherCall<'_>) -> Result<(), UnitError> {
        self.count(call.tasks)
    }

    fn computed(&mut self, call: &VectorCall<'_>) -> Result<(), UnitError> {
        let VectorCall { op, a, .. } = call;
        let cycles = match self.config.vu.exp.early_out {
            false => None,
            true => {
                let begun = Instant::now();
                let vector = match &self.vector {
                    Some(vector) => vector,
                    None => self.vector.insert(ClosedVector::new(&self.config)?),
                };
                let cycles = vector.cycles(&[(op.code, a)]);
                self.modelled += begun.elapsed();
                Some([cycles.elapsed, cycles.busy])
            }
        };
        self.is_computing = true;
        self.batch().computed(op.code, a.len() as u64, cycles);
        Ok(())
    }

    fn composited(&mut self, call: &SplatCall<'_>) -> Result<(), UnitError> {
        let begun = Instant::now();
        let unit = self.splats.as_mut().ok_or(NO_SPLAT_UNIT)?;
        let run = unit.run(call.job)?;
        self.modelled += begun.elapsed();
        self.is_computing = true;
        let counters = run.counters;
        self.batch().gathered += Batch {
            splat_jobs: 1,
            splat_cycles: run.cycles,
            splat_records: counters.records,
            splat_square_sums: counters.square_sums,
            splat_counted: counters.drawn + counters.stopped,
            splat_pixels: call.done.pixels.len() as u64,
            ..Batch::default()
        };
        self.splat_jobs.push((self.batches.len() - 1, run.cycles));
        Ok(())
    }

    fn multiplied(&mut self, product: &Product) {
        let Product {
            rows,
            depth,
            columns,
        } = *product;
        self.batch().multiplied([rows, depth, columns]);
    }
}
