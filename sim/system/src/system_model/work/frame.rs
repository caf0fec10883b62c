//! Work of one frame, in pixel-centric and in memory-centric order.

use std::ops::Add;
use std::time::{Duration, Instant};

use potamoi_base::mask::Mask;
use potamoi_formats::config::Config;
use potamoi_reference::observer::Observed;
use potamoi_reference::{ReferenceUnits, Units};
use potamoi_scene::characterise::{BANKS, LANES};
use potamoi_scene::{Rendered, Scene, SceneError};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use potamoi_cycles::batch::{Batch, BatchEvents, Pricing};
use potamoi_cycles::frame_meter::{FrameMeter, GatherSums};
use potamoi_cycles::mac_array::MacArray;
use potamoi_cycles::splat_unit::SplatSums;

/// Threads in a warp, and banks of a GPU's shared memory.
const WARP: usize = 32;

/// Reads of feature vectors in pixel-centric order through a cache with optimal (oracle)
/// replacement: no cache of that size has fewer misses.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Reads {
    /// Tables of the model.
    pub tables: u64,
    /// Bytes of the model's feature vectors.
    pub model_bytes: u64,
    /// Vectors read.
    pub reads: u64,
    /// Bytes read.
    pub bytes: u64,
    /// Sectors of 32 bytes read.
    pub sectors: u64,
    /// Bytes of misses.
    pub missed_bytes: u64,
    /// Vectors that miss.
    pub misses: u64,
    /// Misses that are not adjacent to the miss before.
    pub not_streaming: u64,
    /// Bank conflict rate: reads that wait for another vector of their bank, over all reads, with
    /// 32 lanes and 32 banks that hold whole vectors.
    pub conflict_rate: f64,
}

/// (pixel, Gaussian) pairs of splats.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct PixelPairs {
    /// Pairs that are evaluated, whether they count or not.
    pub pairs_evaluated: u64,
    /// Pairs that contribute to a pixel.
    pub pairs_drawn: u64,
    /// Pairs at which a pixel terminates early.
    pub pairs_stopped: u64,
}

impl Add for PixelPairs {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            pairs_evaluated: self.pairs_evaluated + other.pairs_evaluated,
            pairs_drawn: self.pairs_drawn + other.pairs_drawn,
            pairs_stopped: self.pairs_stopped + other.pairs_stopped,
        }
    }
}

/// Work of a frame, or of some of its pixels. `B` is [`Batch`], or [`BatchEvents`] where vector unit
/// and array are left open.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FrameWork<B = Batch> {
    /// Pixels rendered.
    pub pixels: u64,
    /// Pixels of the whole frame.
    pub frame_pixels: u64,
    /// Samples along rays, gathered or not; 0 for splats.
    pub samples: u64,
    /// Gaussians of the model; 0 for fields.
    pub gaussians: u64,
    /// Visible Gaussians: those that touch a tile.
    pub visible: u64,
    /// Colour coefficients of a Gaussian that the model has and that are not used.
    #[serde(default, skip_serializing_if = "super::is_default")]
    pub left_out_coefficients: u64,
    /// (tile, Gaussian) pairs that are listed.
    pub pairs: u64,
    /// Pairs that the GPU tests before, of which [`FrameWork::pairs`] are left; 0 where it tests none.
    #[serde(default, skip_serializing_if = "super::is_default")]
    pub pairs_tested: u64,
    /// (pixel, Gaussian) pairs; `None` for fields.
    pub pixel_pairs: Option<PixelPairs>,
    /// Bytes of records that the GPU writes, each once.
    pub record_bytes: u64,
    /// Spilled bytes, out and back: partial sums and held records that do not fit on chip.
    pub spilled_bytes: u64,
    /// Bytes of rows that are fetched one by one.
    pub scattered_bytes: u64,
    /// Reads in pixel-centric order.
    pub reads: Reads,
    /// Work in memory-centric order, by step.
    pub batches: Vec<B>,
}

/// Work of a frame before units and cache are known.
pub(super) type FrameEvents = FrameWork<BatchEvents>;

impl FrameEvents {
    /// Renders what a scene's camera sees, or a mask's pixels of it, through units of the
    /// configuration, and counts the events. Reads are left at 0, see [`Reads::of`].
    ///
    /// # Errors
    /// As [`Scene::render_fixed`].
    pub(super) fn of(
        scene: &Scene,
        config: &Config,
        only: Option<&Mask>,
    ) -> Result<Self, SceneError> {
        let mut twins = ReferenceUnits::new(config);
        Ok(Rendering::of(scene, config, only, &mut twins)?.events)
    }

    /// The work with a vector unit, an array and reads.
    pub(super) fn priced(&self, with: &Pricing, reads: Reads) -> FrameWork {
        FrameWork {
            pixels: self.pixels,
            frame_pixels: self.frame_pixels,
            samples: self.samples,
            gaussians: self.gaussians,
            visible: self.visible,
            left_out_coefficients: self.left_out_coefficients,
            pairs: self.pairs,
            pairs_tested: self.pairs_tested,
            pixel_pairs: self.pixel_pairs,
            record_bytes: self.record_bytes,
            spilled_bytes: self.spilled_bytes,
            scattered_bytes: self.scattered_bytes,
            reads,
            batches: (self.batches.iter()).map(|own| own.priced(with)).collect(),
        }
    }
}

impl Reads {
    /// Reads of what a scene's camera sees, or of a mask's pixels of it, with a cache of so many
    /// bytes. Nothing is rendered through units.
    ///
    /// # Errors
    /// As [`Scene::accesses`].
    pub(super) fn of(
        scene: &Scene,
        config: &Config,
        cache: u32,
        only: Option<&Mask>,
    ) -> Result<Self, SceneError> {
        let accesses = scene.accesses(config, cache, only)?;
        let memory = accesses.memory;
        let at = |all: &[usize], of: usize| all.iter().position(|v| *v == of).unwrap_or(0);
        let banks: Vec<usize> = BANKS.iter().map(|b| *b as usize).collect();
        let conflicts = accesses.banks[at(&LANES, WARP)][at(&banks, WARP)];
        Ok(Self {
            tables: accesses.tables.len() as u64,
            model_bytes: accesses.stored_bytes(),
            reads: memory.reads,
            bytes: memory.read_bytes,
            sectors: memory.sectors,
            missed_bytes: memory.bytes,
            misses: memory.misses,
            not_streaming: memory.not_streaming,
            conflict_rate: conflicts.conflict_rate(),
        })
    }
}

/// A rendered frame with its events.
struct Rendering {
    events: FrameEvents,
    rendered: Rendered,
    sums: GatherSums,
    modelled: Duration,
}

impl Rendering {
    fn of(
        scene: &Scene,
        config: &Config,
        only: Option<&Mask>,
        units: &mut dyn Units,
    ) -> Result<Self, SceneError> {
        let mut meter = FrameMeter::new(config);
        let mut units = Observed::new(units, config).by(&mut meter);
        let rendered = match only {
            None => scene.render_fixed(config, &mut units)?,
            Some(mask) => scene.render_fixed_masked(config, mask, &mut units)?,
        };
        let (modelled, sums) = (meter.modelled(), meter.sums());
        let counts = &rendered.counts;
        let camera = scene.camera();
        let frame_pixels = u64::from(camera.width) * u64::from(camera.height);
        let splats = counts.splats.unwrap_or_default();
        let events = FrameEvents {
            pixels: only.map_or(frame_pixels, |mask| mask.count() as u64),
            frame_pixels,
            samples: counts.samples,
            gaussians: splats.gaussians,
            visible: splats.visible,
            left_out_coefficients: scene.left_out_coefficients(),
            pairs: splats.pairs,
            pairs_tested: splats.pair_test.map_or(0, |test| test.pairs),
            pixel_pairs: counts.splats.map(|splats| PixelPairs {
                pairs_evaluated: splats.pairs_evaluated,
                pairs_drawn: splats.pairs_drawn,
                pairs_stopped: splats.pairs_stopped,
            }),
            record_bytes: counts.streams.records_written,
            spilled_bytes: counts.streams.spills + 2 * counts.streams.partial_sums,
            scattered_bytes: counts.scattered_bytes,
            reads: Reads::default(),
            batches: meter.into_events(),
        };
        Ok(Self {
            events,
            rendered,
            sums,
            modelled,
        })
    }
}

/// Cycles of the units in a frame.
#[derive(Debug, Clone, Copy)]
pub struct UnitCycles {
    /// Of the gathering unit.
    pub gather: u64,
    /// Of the vector unit.
    pub vector: u64,
    /// Of all splat units.
    pub splat: u64,
}

/// A frame with its counted work.
#[derive(Debug)]
pub struct Counted {
    /// Its work.
    pub work: FrameWork,
    /// Its picture.
    pub rendered: Rendered,
    /// Gathering cycles by closed form.
    pub sums: GatherSums,
    /// Wall time of the cycle models.
    pub modelled: Duration,
}

impl FrameWork {
    /// Renders what a scene's camera sees, or a mask's pixels of it, through the reference units,
    /// and counts the work. `cache` is the size of the GPU's cache in bytes.
    ///
    /// # Errors
    /// As [`Scene::render_fixed`].
    pub fn count(
        scene: &Scene,
        config: &Config,
        array: MacArray,
        cache: u32,
        only: Option<&Mask>,
    ) -> Result<Self, SceneError> {
        let mut twins = ReferenceUnits::new(config);
        Self::count_through(scene, config, array, cache, only, &mut twins)
    }

    /// Counts the work through other units of the configuration.
    ///
    /// # Errors
    /// As [`Scene::render_fixed`].
    pub(crate) fn count_through(
        scene: &Scene,
        config: &Config,
        array: MacArray,
        cache: u32,
        only: Option<&Mask>,
        units: &mut dyn Units,
    ) -> Result<Self, SceneError> {
        Ok(Self::rendered(scene, config, array, cache, only, units)?.work)
    }

    /// Counts the work, and returns it with the picture.
    ///
    /// # Errors
    /// As [`Scene::render_fixed`].
    pub fn rendered(
        scene: &Scene,
        config: &Config,
        array: MacArray,
        cache: u32,
        only: Option<&Mask>,
        units: &mut dyn Units,
    ) -> Result<Counted, SceneError> {
        let Rendering {
            events,
            rendered,
            sums,
            mut modelled,
        } = Rendering::of(scene, config, only, units)?;
        let begun = Instant::now();
        let pricing = Pricing::new(config, array);
        let pricing = pricing.map_err(|error| SceneError::of_unit(error.into()))?;
        let work = events.priced(&pricing, Reads::default());
        modelled += begun.elapsed();
        let reads = Reads::of(scene, config, cache, only)?;
        Ok(Counted {
            work: Self { reads, ..work },
            rendered,
            sums,
            modelled,
        })
    }

    /// Sum of all batches.
    #[must_use]
    pub fn total(&self) -> Batch {
        let mut sum = Batch::default();
        self.batches.iter().for_each(|own| sum += *own);
        sum
    }

    /// The same work with other total cycles of the units, distributed over the batches in
    /// proportion to their own. Splat units side by side keep their share of them.
    #[must_use]
    pub fn with_cycles(&self, cycles: UnitCycles) -> Self {
        let total = self.total();
        let mut own = self.clone();
        let scale = |part: u64, whole: u64, to: u64| {
            (u128::from(part) * u128::from(to) / u128::from(whole.max(1))) as u64
        };
        let elapsed = scale(total.splat_elapsed, total.splat_cycles, cycles.splat);
        for batch in &mut own.batches {
            batch.gather_cycles = scale(batch.gather_cycles, total.gather_cycles, cycles.gather);
            batch.vector_cycles = scale(batch.vector_cycles, total.vector_cycles, cycles.vector);
            batch.splat_cycles = scale(batch.splat_cycles, total.splat_cycles, cycles.splat);
            batch.splat_elapsed = scale(batch.splat_elapsed, total.splat_elapsed, elapsed);
        }
        // What rounding left.
        let spread = own.total();
        if let Some(last) = own.batches.last_mut() {
            last.gather_cycles += cycles.gather.saturating_sub(spread.gather_cycles);
            last.vector_cycles += cycles.vector.saturating_sub(spread.vector_cycles);
            last.splat_cycles += cycles.splat.saturating_sub(spread.splat_cycles);
            last.splat_elapsed += elapsed.saturating_sub(spread.splat_elapsed);
        }
        own
    }

    /// Closed-form estimate without simulation: all MVoxels as one, by `sums`, all vectors at their
    /// units' throughput, without pipeline fill, stalls and drain, and splat units as if all their jobs were one.
    ///
    /// # Errors
    /// A configuration that breaks its rules.
    pub fn as_one_sum(&self, sums: GatherSums, config: &Config) -> Result<Self, SceneError> {
        let total = self.total();
        let splats = SplatSums {
            jobs: total.splat_jobs,
            records: total.splat_records,
            square_sums: total.splat_square_sums,
            exponentials: total.splat_counted,
            pixels: total.splat_pixels,
        };
        let splat = splats.cycles(config);
        let whole = Self {
            batches: vec![total],
            ..self.clone()
        };
        Ok(whole.with_cycles(UnitCycles {
            gather: sums.cycles(),
            vector: total.vector_busy,
            splat: splat.map_err(|error| SceneError::of_unit(error.into()))?,
        }))
    }

    /// The same frame with all tables on chip, one bank each, which delivers a vertex a cycle
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
