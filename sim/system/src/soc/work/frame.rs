//! What one frame asks for, in both orders.

use std::time::Duration;

use potamoi_base::mask::Mask;
use potamoi_formats::config::Config;
use potamoi_reference::observer::Observed;
use potamoi_reference::{Twins, Units};
use potamoi_scene::characterise::{BANKS, LANES};
use potamoi_scene::{Rendered, Scene, SceneError};
use serde::{Deserialize, Serialize};

use super::super::npu::Array;
use super::meter::{Batch, Meter, Sums};

/// Lanes of a warp, and banks of a GPU's shared memory.
const WARP: usize = 32;

/// Reads of feature vectors in pixel-centric order, through a cache with oracle replacement:
/// no cache of that size has fewer misses.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Reads {
    /// Tables of the model.
    pub tables: u64,
    /// Bytes of the model's vectors.
    pub model_bytes: u64,
    /// Vectors read.
    pub reads: u64,
    /// Their bytes.
    pub bytes: u64,
    /// Their parts of 32 bytes.
    pub sectors: u64,
    /// Bytes that the cache could not serve.
    pub missed_bytes: u64,
    /// Vectors that it could not serve.
    pub misses: u64,
    /// Of them, those that do not lie behind the one before.
    pub not_streaming: u64,
    /// Reads that wait for another vector of their bank, over all: 32 lanes and 32 banks that
    /// hold whole vectors.
    pub conflict_rate: f64,
}

/// Work of a frame, or of some of its pixels.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrameWork {
    /// Pixels that are rendered.
    pub pixels: u64,
    /// Pixels of the whole frame.
    pub frame_pixels: u64,
    /// Samples along rays, gathered or not; none of splats.
    pub samples: u64,
    /// Gaussians of the model; none of fields.
    pub gaussians: u64,
    /// Gaussians that touch a tile.
    pub visible: u64,
    /// Coefficients of a Gaussian's colours that the model has and that are left out.
    #[serde(default, skip_serializing_if = "super::is_default")]
    pub left_out_coefficients: u64,
    /// (tile, Gaussian) pairs.
    pub pairs: u64,
    /// Bytes of records that the GPU writes, each once.
    pub record_bytes: u64,
    /// Bytes of partial sums and of records held back that did not fit on chip, out and back.
    pub spilled_bytes: u64,
    /// Of the bytes of rows, those that are fetched one by one.
    pub scattered_bytes: u64,
    /// Pixel-centric order.
    pub reads: Reads,
    /// Memory-centric order, step by step.
    pub batches: Vec<Batch>,
}

/// A frame that was rendered to be counted.
#[derive(Debug)]
pub struct Counted {
    /// What it asks for.
    pub work: FrameWork,
    /// What it shows.
    pub rendered: Rendered,
    /// Cycles of gathering by sums.
    pub sums: Sums,
    /// What the cycle models took of the time.
    pub modelled: Duration,
}

impl FrameWork {
    /// Counts what a scene's camera sees, or a mask's pixels of it, by rendering it through
    /// the twins. `cache` are the bytes of the GPU's cache.
    ///
    /// # Errors
    /// As [`Scene::render_fixed`].
    pub fn count(
        scene: &Scene,
        config: &Config,
        array: Array,
        cache: u32,
        only: Option<&Mask>,
    ) -> Result<Self, SceneError> {
        let mut twins = Twins::new(config);
        Self::count_through(scene, config, array, cache, only, &mut twins)
    }

    /// The same through other units of the configuration.
    ///
    /// # Errors
    /// As [`Scene::render_fixed`].
    pub fn count_through(
        scene: &Scene,
        config: &Config,
        array: Array,
        cache: u32,
        only: Option<&Mask>,
        units: &mut dyn Units,
    ) -> Result<Self, SceneError> {
        Ok(Self::rendered(scene, config, array, cache, only, units)?.work)
    }

    /// The same with what was rendered.
    ///
    /// # Errors
    /// As [`Scene::render_fixed`].
    pub fn rendered(
        scene: &Scene,
        config: &Config,
        array: Array,
        cache: u32,
        only: Option<&Mask>,
        units: &mut dyn Units,
    ) -> Result<Counted, SceneError> {
        let mut meter = Meter::new(config, array);
        let mut units = Observed::new(units, config).by(&mut meter);
        let rendered = match only {
            None => scene.render_fixed(config, &mut units)?,
            Some(mask) => scene.render_fixed_masked(config, mask, &mut units)?,
        };
        let (modelled, sums) = (meter.modelled(), meter.sums());
        let batches = meter.into_batches();
        let counts = &rendered.counts;
        let accesses = scene.accesses(cache, only)?;
        let memory = accesses.memory;
        let at = |all: &[usize], of: usize| all.iter().position(|v| *v == of).unwrap_or(0);
        let banks: Vec<usize> = BANKS.iter().map(|b| *b as usize).collect();
        let conflicts = accesses.banks[at(&LANES, WARP)][at(&banks, WARP)];
        let camera = scene.camera();
        let frame_pixels = u64::from(camera.width) * u64::from(camera.height);
        let splats = counts.splats.unwrap_or_default();
        let work = Self {
            pixels: only.map_or(frame_pixels, |mask| mask.count() as u64),
            frame_pixels,
            samples: counts.samples,
            gaussians: splats.gaussians,
            visible: splats.visible,
            left_out_coefficients: scene.left_out_coefficients(),
            pairs: splats.pairs,
            record_bytes: counts.streams.records_written,
            spilled_bytes: counts.streams.spills + 2 * counts.streams.partial_sums,
            scattered_bytes: counts.scattered_bytes,
            reads: Reads {
                tables: accesses.tables.len() as u64,
                model_bytes: accesses.stored_bytes(),
                reads: memory.reads,
                bytes: memory.read_bytes,
                sectors: memory.sectors,
                missed_bytes: memory.bytes,
                misses: memory.misses,
                not_streaming: memory.not_streaming,
                conflict_rate: conflicts.conflict_rate(),
            },
            batches,
        };
        Ok(Counted {
            work,
            rendered,
            sums,
            modelled,
        })
    }

    /// All batches together.
    #[must_use]
    pub fn total(&self) -> Batch {
        let mut sum = Batch::default();
        self.batches.iter().for_each(|own| sum += *own);
        sum
    }

    /// The same with cycles of units in all that were found otherwise, spread over the batches as
    /// these have them.
    #[must_use]
    pub fn with_cycles(&self, gather: u64, vector: u64) -> Self {
        let total = self.total();
        let mut own = self.clone();
        let scale = |part: u64, whole: u64, to: u64| {
            (u128::from(part) * u128::from(to) / u128::from(whole.max(1))) as u64
        };
        for batch in &mut own.batches {
            batch.gather_cycles = scale(batch.gather_cycles, total.gather_cycles, gather);
            batch.vector_cycles = scale(batch.vector_cycles, total.vector_cycles, vector);
        }
        // What rounding left.
        let spread = own.total();
        if let Some(last) = own.batches.last_mut() {
            last.gather_cycles += gather - spread.gather_cycles.min(gather);
            last.vector_cycles += vector - spread.vector_cycles.min(vector);
        }
        own
    }

    /// What is known without stepping through anything: all MVoxels as one, by `sums`, all vectors
    /// at the rate of their units, without fills, stalls and ends.
    #[must_use]
    pub fn as_one_sum(&self, sums: Sums) -> Self {
        let total = self.total();
        Self {
            batches: vec![total],
            ..self.clone()
        }
        .with_cycles(sums.cycles(), total.vector_busy)
    }

    /// The same frame where all tables are on chip, a bank each, which gives a vertex a cycle
    /// (NGPC, Mubarik et al., ISCA 2023): a sample takes as many cycles as it has vertices in a
    /// table, and nothing is loaded.
    #[must_use]
    pub fn with_resident_tables(&self) -> Self {
        const VERTICES: u64 = 8;
        let tables = self.reads.tables.max(1);
        let mut own = Self {
            scattered_bytes: 0,
            spilled_bytes: 0,
            ..self.clone()
        };
        for batch in &mut own.batches {
            batch.gather_cycles = batch.entries.div_ceil(tables) * VERTICES;
            batch.gather_busy = batch.gather_cycles;
            (batch.row_bytes, batch.rit_bytes, batch.rit_read_bytes) = (0, 0, 0);
        }
        own
    }
}
