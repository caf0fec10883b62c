//! The paper's motivation figures of a scene: what is read, what misses, what conflicts.

use potamoi_formats::config::Config;
use potamoi_scene::Scene;
use potamoi_scene::characterise::{BANKS, Banks, LANES, Memory, Stages, Traffic, Vectors};
use serde::Serialize;

use crate::ExploreError;

/// The buffer of the paper's figures, in bytes.
const BUFFER: u32 = 2 << 20;

/// What was found of one scene.
#[derive(Debug, Clone, Serialize)]
pub struct Characterisation {
    /// The scene's name.
    pub scene: String,
    /// The model's algorithm.
    pub algorithm: &'static str,
    /// Pixels of a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Whether reads are of tables as large as the algorithm's authors use.
    pub full_size: bool,
    /// Feature vectors of the model, table after table.
    pub tables: Vec<Vectors>,
    /// Bytes of the feature vectors of all tables.
    pub model_bytes: u64,
    /// Bytes of the buffer that misses are of.
    pub buffer_bytes: u32,
    /// Accesses to memory in the order of pixels.
    pub memory: Memory,
    /// Misses of the buffer with oracle replacement over reads, 0 to 1.
    pub miss_rate: f64,
    /// Misses that do not follow the one before over all, 0 to 1.
    pub not_streaming_rate: f64,
    /// Conflicts on banks, by rays and banks.
    pub banks: Vec<BankPoint>,
    /// Seconds, measured.
    pub stages: Stages,
    /// What the paper states.
    pub paper: PaperMotivation,
    /// Of splats alone.
    pub merging: Option<Merging>,
    /// By ray group, and by halo where MVoxels share vertices.
    pub traffic: Vec<Traffic>,
    /// What a model's file leaves open.
    pub not_checked: Vec<String>,
}

/// What merging of cells does to the MVoxels of splats.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Merging {
    /// Gaussians that an MVoxel holds.
    pub rows: u32,
    /// MVoxels without merging.
    pub mvoxels_before: usize,
    /// MVoxels with it.
    pub mvoxels_after: usize,
    /// Gaussians of an MVoxel on average, without merging.
    pub points_before: f64,
    /// The same with it.
    pub points_after: f64,
    /// Bytes of the tree.
    pub tree_bytes: usize,
}

/// Conflicts of so many rays on so many banks.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct BankPoint {
    /// Rays whose vertices are read at once.
    pub rays: usize,
    /// Banks that hold vectors whole.
    pub banks: u32,
    /// Reads and conflicts.
    pub counts: Banks,
    /// Conflicts over reads, 0 to 1.
    pub conflict_rate: f64,
}

/// What the paper states (Secs. "Motivation", "Memory Optimizations"): of an algorithm where it
/// names one, of all of them otherwise. Rates are from 0 to 1.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct PaperMotivation {
    /// Bytes of the feature vectors of its models.
    pub model_bytes: [u64; 2],
    /// Misses of a 2 MB buffer with oracle replacement, over its algorithms.
    pub miss_rate_average: f64,
    /// The most of them.
    pub miss_rate_most: f64,
    /// Accesses to memory that do not stream are more than this.
    pub not_streaming_above: f64,
    /// Conflicts of 16 rays on 16 banks: the algorithm's own, or the average.
    pub conflicts_16_on_16: Option<f64>,
    /// Their average.
    pub conflicts_16_on_16_average: f64,
    /// Conflicts of 64 rays on 16 banks.
    pub conflicts_64_on_16: Option<f64>,
    /// Gathering takes more than this of the time, on average, on a mobile GPU.
    pub gathering_above: f64,
    /// Gaussians of an MVoxel before and after merging.
    pub points: Option<[f64; 2]>,
    /// Bytes of the octree, at most.
    pub tree_bytes: Option<u64>,
    /// Of the bytes of the memory-centric order, those that do not stream.
    pub scattered: Option<f64>,
}

impl PaperMotivation {
    /// Of an algorithm.
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
    /// Counts the accesses of the frame that a scene's camera sees; `full` takes tables as large as
    /// the algorithm's authors use, with the model's samples.
    ///
    /// # Errors
    /// A scene that the configuration cannot render, or of which nothing is read.
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
            not_checked: scene.left_open(),
            tables: counted.accesses.tables,
        })
    }
}

/// Ray groups from 16 pixels a side to the frame.
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
