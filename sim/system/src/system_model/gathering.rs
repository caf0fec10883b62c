//! Gathering alone: on the GPU in pixel-centric order, and on the gathering unit in MVoxel order.

use schemars::JsonSchema;
use serde::Serialize;

use super::at_bounds::AtBounds;
use super::error::ModelError;
use super::memory::Memory;
use super::outcome::Model;
use super::transfers::{ReplayedRates, missed_transfers, unit_transfers};
use super::variant::Gathering;
use super::work::{FrameWork, PathReplay};

/// Time of gathering a frame in both ways, and its memory energy.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Gathered {
    /// Nanoseconds on the GPU, waits for memory included.
    pub gpu_ns: AtBounds<f64>,
    /// Nanoseconds on the gathering unit, waits for memory included.
    pub unit_ns: AtBounds<f64>,
    /// Memory energy.
    pub memory: MemorySaving,
}

/// Memory energy of gathering in picojoules, and its saving by cause (paper, Sec. "Memory Saving
/// Contribution"): less traffic, at the former mean energy of a byte, and streaming, for the bytes
/// that remain.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct MemorySaving {
    /// In pixel-centric order.
    pub before_pj: f64,
    /// In memory-centric order.
    pub after_pj: f64,
    /// Saving by less traffic.
    pub by_traffic_pj: f64,
    /// Saving by streaming.
    pub by_streaming_pj: f64,
}

impl MemorySaving {
    /// Saving for a frame. The bytes of memory-centric order are rows, the RIT written and read,
    /// and spills.
    #[must_use]
    pub fn of(memory: &Memory, replay: Option<&PathReplay>, work: &FrameWork) -> Self {
        let known = ReplayedRates::of(replay, work);
        let before = missed_transfers(work, &known);
        let (before_bytes, before_pj) = (before.bytes(), before.pj(memory));
        let total = work.total();
        let mut transfers = unit_transfers(work, &total, 1.0, &known);
        transfers.written += total.rit_bytes as f64;
        let (after_bytes, after_pj) = (transfers.bytes(), transfers.pj(memory));
        let each = before_pj / before_bytes.max(1.0);
        Self {
            before_pj,
            after_pj,
            by_traffic_pj: (before_bytes - after_bytes) * each,
            by_streaming_pj: after_bytes * each - after_pj,
        }
    }

    /// Share of the saving that is due to less traffic, from 0 to 1; `None` where nothing is saved.
    #[must_use]
    pub fn traffic_share(&self) -> Option<f64> {
        let saved = self.before_pj - self.after_pj;
        (saved > 0.0).then(|| self.by_traffic_pj / saved)
    }
}

impl Model<'_> {
    /// Models the gathering of a frame in both ways.
    ///
    /// # Errors
    /// As [`Model::frame`].
    pub fn gathered(&self, work: &FrameWork) -> Result<Gathered, ModelError> {
        let ns = |gathering| -> Result<AtBounds<f64>, ModelError> {
            Ok(self.frame(work, gathering)?.map(|run| {
                let stage = run.stages.get("gathering").copied().unwrap_or_default();
                stage.own_ns + stage.memory_ns
            }))
        };
        Ok(Gathered {
            gpu_ns: ns(Gathering::PixelOrder)?,
            unit_ns: ns(Gathering::Unit)?,
            memory: MemorySaving::of(self.memory, self.replay, work),
        })
    }
}
