//! Work of the units for a frame, measured call by call.

use std::time::{Duration, Instant};

use super::{ClosedVector, GatherWork, runs};
use potamoi_formats::config::{Config, RitPath};
use potamoi_reference::observer::{GatherCall, Observer, VectorCall};
use potamoi_reference::{GatherTask, Product, UnitError};
use serde::{Deserialize, Serialize};

use super::mac_array::MacArray;

/// Bytes of a feature code or an activation.
const CODE: u64 = 2;
/// Bytes of an operand or a result of the vector unit.
const OPERAND: u64 = 4;

/// One step of a frame's pipeline: a gathering and the computation on its results. A batch begins
/// with the first gather after a vector operation.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Batch {
    /// Runs of the gathering unit, each from reset.
    pub runs: u64,
    /// Tasks, one for each MVoxel.
    pub mvoxels: u64,
    /// RIT entries.
    pub entries: u64,
    /// Cycles of the gathering unit with streams always ready.
    pub gather_cycles: u64,
    /// Busy cycles of the gathering unit, in which it issues.
    pub gather_busy: u64,
    /// Codes read from the MFT: entries times vertices times channels.
    pub codes_read: u64,
    /// Bytes of rows loaded into the MFT.
    pub row_bytes: u64,
    /// Bytes of RIT entries, each counted once.
    pub rit_bytes: u64,
    /// Bytes of RIT entries read by the gathering unit. Entries that exceed both halves of its
    /// buffer are read again for each further segment.
    pub rit_read_bytes: u64,
    /// Bytes of gathered features.
    pub feature_bytes: u64,
    /// Vector operations.
    pub operations: u64,
    /// Elements of vector operations.
    pub elements: u64,
    /// Cycles of the vector unit with streams always ready, each operation from reset.
    pub vector_cycles: u64,
    /// Busy cycles of the vector unit.
    pub vector_busy: u64,
    /// Bytes of operands; the unit keeps none between operations.
    pub operand_bytes: u64,
    /// Bytes of results.
    pub result_bytes: u64,
    /// Matrix products.
    pub products: u64,
    /// Multiply-accumulates of the products.
    pub macs: u64,
    /// Cycles of the MAC array.
    pub array_cycles: u64,
    /// Bytes of the products' inputs, read once for each fold of columns.
    pub input_bytes: u64,
    /// Bytes of weights, counted at each load.
    pub weight_bytes: u64,
    /// Bytes of outputs of products.
    pub output_bytes: u64,
    /// Bytes of partial sums written and read again.
    pub partial_bytes: u64,
}

impl Batch {
    /// All counts.
    fn counts(&mut self) -> [&mut u64; 23] {
        [
            &mut self.runs,
            &mut self.mvoxels,
            &mut self.entries,
            &mut self.gather_cycles,
            &mut self.gather_busy,
            &mut self.codes_read,
            &mut self.row_bytes,
            &mut self.rit_bytes,
            &mut self.rit_read_bytes,
            &mut self.feature_bytes,
            &mut self.operations,
            &mut self.elements,
            &mut self.vector_cycles,
            &mut self.vector_busy,
            &mut self.operand_bytes,
            &mut self.result_bytes,
            &mut self.products,
            &mut self.macs,
            &mut self.array_cycles,
            &mut self.input_bytes,
            &mut self.weight_bytes,
            &mut self.output_bytes,
            &mut self.partial_bytes,
        ]
    }

    /// Splits into equal parts, up to one of each count; the parts sum to the whole.
    pub fn parts(mut self, number: u64) -> impl Iterator<Item = Self> {
        let whole = self.counts().map(|count| *count);
        (0..number).map(move |i| {
            let mut part = Self::default();
            for (own, whole) in part.counts().into_iter().zip(whole) {
                let upto = |i: u64| (u128::from(whole) * u128::from(i) / u128::from(number)) as u64;
                *own = upto(i + 1) - upto(i);
            }
            part
        })
    }
}

impl std::ops::AddAssign for Batch {
    fn add_assign(&mut self, mut other: Self) {
        for (sum, own) in self.counts().into_iter().zip(other.counts()) {
            *sum += *own;
        }
    }
}

/// Observer that counts the work of units of a configuration. Cycle models of the same runs give
/// the cycles.
pub struct FrameMeter {
    config: Config,
    /// Set with the first operation.
    vector: Option<ClosedVector>,
    array: MacArray,
    batches: Vec<Batch>,
    is_computing: bool,
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
    /// A meter for units of `config` and a MAC array.
    #[must_use]
    pub fn new(config: &Config, array: MacArray) -> Self {
        Self {
            config: config.clone(),
            vector: None,
            array,
            batches: vec![Batch::default()],
            is_computing: false,
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
    pub fn into_batches(self) -> Vec<Batch> {
        let some = |batch: &Batch| batch.runs + batch.operations + batch.products > 0;
        self.batches.into_iter().filter(some).collect()
    }

    fn batch(&mut self) -> &mut Batch {
        if self.batches.is_empty() {
            self.batches.push(Batch::default());
        }
        let last = self.batches.len() - 1;
        &mut self.batches[last]
    }

    fn count(&mut self, tasks: &[GatherTask]) -> Result<(), UnitError> {
        if std::mem::take(&mut self.is_computing) {
            self.batches.push(Batch::default());
        }
        for run in runs(tasks) {
            let begun = Instant::now();
            let work = GatherWork::new(&self.config, run)?;
            let own = counted(run, &work, &self.config)?;
            self.modelled += begun.elapsed();
            *self.batch() += own;
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
        let begun = Instant::now();
        let vector = match &self.vector {
            Some(vector) => vector,
            None => self.vector.insert(ClosedVector::new(&self.config)?),
        };
        let cycles = vector.cycles(&[(op.code, a)]);
        self.modelled += begun.elapsed();
        self.is_computing = true;
        *self.batch() += Batch {
            operations: 1,
            elements: a.len() as u64,
            vector_cycles: cycles.elapsed,
            vector_busy: cycles.busy,
            operand_bytes: OPERAND * (a.len() as u64) * (1 + u64::from(op.code.takes_both())),
            result_bytes: OPERAND * a.len() as u64,
            ..Batch::default()
        };
        Ok(())
    }

    fn multiplied(&mut self, product: &Product) {
        let (folds, _) = self.array.folds(product);
        let across = product.columns.div_ceil(self.array.columns);
        let array_cycles = self.array.cycles(product);
        let held = self.array.units();
        let partial_bytes = self.array.partial_bytes(product);
        *self.batch() += Batch {
            products: 1,
            macs: product.operations(),
            array_cycles,
            input_bytes: product.rows * product.depth * across * CODE,
            weight_bytes: folds * held * CODE,
            output_bytes: product.rows * product.columns * CODE,
            partial_bytes,
            ..Batch::default()
        };
    }
}
