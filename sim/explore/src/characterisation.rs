//! The paper's motivation figures for a scene: reads, cache misses and bank conflicts.

use potamoi_formats::config::Config;
use potamoi_scene::Scene;
use potamoi_scene::characterise::{
    BANKS, Banks, LANES, Memory, SplatPairs, Stages, Traffic, Vectors,
};
use schemars::JsonSchema;
use serde::Serialize;

use crate::ExploreError;
use crate::splat_unit_run::{SplatUnitRun, splat_unit_run};

/// Bytes of the buffer in the paper's figures.
const BUFFER: u32 = 2 << 20;

/// Characterisation of a scene.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct Characterisation {
    /// The scene's name.
    pub scene: String,
    /// The model's algorithm.
    pub algorithm: &'static str,
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Whether tables have the size that the algorithm's authors use.
    pub full_size: bool,
    /// Feature vectors of each table of the model.
    pub tables: Vec<Vectors>,
    /// Bytes of the feature vectors of all tables.
    pub model_bytes: u64,
    /// Bytes of the buffer for the miss rate.
    pub buffer_bytes: u32,
    /// Memory accesses in pixel-centric order.
    pub memory: Memory,
    /// Misses of the buffer with oracle replacement, over reads; 0 to 1.
    pub miss_rate: f64,
    /// Misses not adjacent to the miss before, over all misses; 0 to 1.
    pub not_streaming_rate: f64,
    /// Bank conflicts, by rays and banks.
    pub banks: Vec<BankPoint>,
    /// Measured seconds by stage.
    pub stages: Stages,
    /// The paper's figures.
    pub paper: PaperMotivation,
    /// Merging of cells; splats only.
    pub merging: Option<Merging>,
    /// Traffic by ray group, and by halo where MVoxels share vertices.
    pub traffic: Vec<Traffic>,
    /// Pairs of pixel and Gaussian, and how many of them count; splats only, where the configuration's
    /// exponential allows for it.
    pub pairs: Option<SplatPairs>,
    /// The frame on the splat unit, by its cycle model; where the configuration has one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub splat_unit: Option<SplatUnitRun>,
    /// Why all (tile, Gaussian) pairs are listed although the configuration asks for fewer; `None` where
    /// it does not ask, or pairs are left out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub keeps_all_pairs: Option<&'static str>,
    /// Items that the model's file does not determine.
    pub not_checked: Vec<String>,
}

/// Effect of merging cells on the MVoxels of splats.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct Merging {
    /// Capacity of an MVoxel in Gaussians.
    pub rows: u32,
    /// MVoxels before merging.
    pub mvoxels_before: usize,
    /// MVoxels after merging.
    pub mvoxels_after: usize,
    /// Mean Gaussians of an MVoxel before merging.
    pub points_before: f64,
    /// Mean Gaussians of an MVoxel after merging.
    pub points_after: f64,
    /// Bytes of the octree.
    pub tree_bytes: usize,
}

/// Bank conflicts for a number of rays and banks.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct BankPoint {
    /// Rays that read their vertices at once.
    pub rays: usize,
    /// Banks; each holds whole vectors.
    pub banks: u32,
    /// Reads and conflicts.
    pub counts: Banks,
    /// Conflicts over reads, 0 to 1.
    pub conflict_rate: f64,
}

/// The paper's figures (Secs. "Motivation", "Memory Optimizations"): of an algorithm where the
/// paper names it, else of all. Rates are from 0 to 1.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct PaperMotivation {
    /// Range of bytes of its models' feature vectors.
    pub model_bytes: [u64; 2],
    /// Miss rate of a 2 MB buffer with oracle replacement, mean over its algorithms.
    pub miss_rate_average: f64,
    /// Largest miss rate among its algorithms.
    pub miss_rate_most: f64,
    /// Lower bound of the share of non-streaming accesses.
    pub not_streaming_above: f64,
    /// Conflict rate of 16 rays on 16 banks: the algorithm's own, or the mean.
    pub conflicts_16_on_16: Option<f64>,
    /// Mean conflict rate of 16 rays on 16 banks.
    pub conflicts_16_on_16_average: f64,
    /// Conflict rate of 64 rays on 16 banks.
    pub conflicts_64_on_16: Option<f64>,
    /// Lower bound of gathering's mean share of the time on a mobile GPU.
    pub gathering_above: f64,
    /// Mean Gaussians of an MVoxel before and after merging.
    pub points: Option<[f64; 2]>,
    /// Upper bound of the octree's bytes.
    pub tree_bytes: Option<u64>,
    /// Share of bytes in memory-centric order that do not stream.
    pub scattered: Option<f64>,
}

impl PaperMotivation {
    /// Figures of an algorithm.
    #[must_use]
    pub fn of(algorithm: &str) -> Self {
        let splats = matches!(algorithm, "3DGS" | "Compact-3DGS");
        let hashed = algorithm == "Instant-NGP";
        Self {
            model_bytes: [10_000_000, 1_000_000_000],
            miss_rate_average: 0.41,
            miss_rate_most: 0.92,
            not_streaming_above: if splats || hashed { 0.99 } else { 0.87 },
            conflicts_16_on_16: (algorithm == "EfficientNeRF").then_some(0.83),
            conflicts_16_on_16_average: 0.51,
            conflicts_64_on_16: hashed.then_some(0.80),
            gathering_above: 0.64,
            points: splats.then_some([7.2, 172.8]),
            tree_bytes: splats.then_some(200_000),
            scattered: hashed.then_some(0.5),
        }
    }
}

impl Characterisation {
    /// Characterises the frame that a scene's camera sees. `full` enlarges tables to the size that
    /// the algorithm's authors use, with the model's samples.
    ///
    /// # Errors
    /// A scene that the configuration cannot render, or that reads nothing.
    pub fn of(scene: &Scene, config: &Config, full: bool) -> Result<Self, ExploreError> {
        let counted = scene.characterise(config, BUFFER, &sides(scene), full)?;
        let (accesses, memory) = (&counted.accesses, counted.accesses.memory);
        if memory.reads == 0 {
            return Err(ExploreError::Inconclusive(format!(
                "{} reads nothing from here; choose a camera with something in view",
                scene.name()
            )));
        }
        let points = LANES.iter().zip(&accesses.banks);
        let banks = points.flat_map(|(rays, own)| {
            let own = BANKS.into_iter().zip(own);
            own.map(|(banks, counts)| BankPoint {
                rays: *rays,
                banks,
                counts: *counts,
                conflict_rate: counts.conflict_rate(),
            })
        });
        let algorithm = scene.model().algorithm();
        Ok(Self {
            scene: scene.name().to_owned(),
            algorithm,
            width: scene.camera().width,
            height: scene.camera().height,
            full_size: full && scene.model().full_size().is_some(),
            model_bytes: accesses.stored_bytes(),
            buffer_bytes: BUFFER,
            memory,
            miss_rate: memory.miss_rate(),
            not_streaming_rate: memory.not_streaming_rate(),
            banks: banks.collect(),
            stages: counted.stages,
            paper: PaperMotivation::of(algorithm),
            merging: merging(scene, config.mvoxel.rows),
            traffic: counted.traffic,
            pairs: counted.pairs,
            splat_unit: splat_unit_run(scene, config)?,
            keeps_all_pairs: scene.keeps_all_pairs(config),
            not_checked: scene.left_open(),
            tables: counted.accesses.tables,
        })
    }
}

/// Sides of ray groups in pixels, from 16 to the frame.
fn sides(scene: &Scene) -> Vec<u32> {
    let frame = scene.camera().width.max(scene.camera().height);
    let smaller = [16, 32, 64, 128, 256, 512];
    let smaller = smaller.into_iter().filter(|side| *side < frame);
    smaller.chain([frame]).collect()
}

fn merging(scene: &Scene, rows: u32) -> Option<Merging> {
    let tree = scene.octree(rows as usize)?;
    let points: usize = tree.points().iter().sum();
    let per = |mvoxels: usize| points as f64 / mvoxels.max(1) as f64;
    Some(Merging {
        rows,
        mvoxels_before: tree.cells().len(),
        mvoxels_after: tree.points().len(),
        points_before: per(tree.cells().len()),
        points_after: per(tree.points().len()),
        tree_bytes: tree.bytes(),
    })
}
