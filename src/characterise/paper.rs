//! What the paper states (Secs. "Motivation", "Memory Optimizations"): of an
//! algorithm where it names one, of all of them otherwise. Rates are from 0 to 1.

use serde::Serialize;

/// The paper's figures for an algorithm.
#[derive(Debug, Clone, Copy, Serialize)]
pub(super) struct Paper {
    /// Bytes of the feature vectors of its models.
    pub(super) model_bytes: [u64; 2],
    /// Misses of a 2 MB buffer with oracle replacement, over its algorithms.
    pub(super) miss_rate_average: f64,
    pub(super) miss_rate_most: f64,
    /// Accesses to memory that do not stream are more than this.
    pub(super) not_streaming_above: f64,
    /// Conflicts of 16 rays on 16 banks: the algorithm's own, or the average.
    pub(super) conflicts_16_on_16: Option<f64>,
    pub(super) conflicts_16_on_16_average: f64,
    /// Conflicts of 64 rays on 16 banks.
    pub(super) conflicts_64_on_16: Option<f64>,
    /// Gathering takes more than this of the time, on average, on a mobile GPU.
    pub(super) gathering_above: f64,
    /// Gaussians an MVoxel before and after merging, and bytes of the octree at
    /// most.
    pub(super) points: Option<[f64; 2]>,
    pub(super) tree_bytes: Option<u64>,
    /// Of the bytes of the memory-centric order, those that do not stream.
    pub(super) scattered: Option<f64>,
}

impl Paper {
    pub(super) fn of(algorithm: &str) -> Self {
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

    /// The share of conflicts of 16 rays on 16 banks, as text.
    pub(super) fn conflicts(&self) -> String {
        let average = percent(self.conflicts_16_on_16_average);
        let own = self.conflicts_16_on_16.map(percent);
        own.map_or(format!("{average} on average"), |own| own)
    }
}

/// A whole number of per cent.
pub(super) fn percent(rate: f64) -> String {
    format!("{:.0} %", 100.0 * rate)
}
