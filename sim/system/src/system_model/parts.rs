//! Parts of a frame's time and energy.

use schemars::JsonSchema;
use serde::Serialize;

use super::job_scheduler::Shared;

/// Nanoseconds of a stage, averaged over frames.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
pub struct StageTime {
    /// At work.
    pub own_ns: f64,
    /// Own work done, transfers still under way on any shared channel.
    pub memory_ns: f64,
    /// The same, by the channel of the last transfer.
    pub last_through: LastThrough,
    /// Part of the stage was ready and waited for its resource.
    pub waiting_ns: f64,
}

/// Nanoseconds that jobs waited for transfers, by the channel of the last transfer.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
pub struct LastThrough {
    /// Memory.
    pub memory_ns: f64,
    /// Interconnect of memory, GPU and accelerator.
    pub interconnect_ns: f64,
    /// Ports of the global feature buffer.
    pub feature_buffer_ns: f64,
    /// Port of the weight buffer.
    pub weight_buffer_ns: f64,
}

impl LastThrough {
    pub(super) fn wait(&mut self, of: Shared, ns: f64) {
        *match of {
            Shared::Memory => &mut self.memory_ns,
            Shared::Interconnect => &mut self.interconnect_ns,
            Shared::Features(_) => &mut self.feature_buffer_ns,
            Shared::Weights => &mut self.weight_buffer_ns,
        } += ns;
    }

    /// Name of the channel with the longest wait.
    #[must_use]
    pub fn most(&self) -> &'static str {
        let all = [
            ("memory", self.memory_ns),
            ("interconnect", self.interconnect_ns),
            ("feature buffer", self.feature_buffer_ns),
            ("weight buffer", self.weight_buffer_ns),
        ];
        let most = |best: (_, f64), own: (_, f64)| if own.1 > best.1 { own } else { best };
        all.into_iter().fold(all[0], most).0
    }
}

/// Energy of the device by part, in millijoules a frame; `None` where it is not known.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, JsonSchema)]
pub struct EnergyByPart {
    /// The GPU, at work and idle.
    pub gpu_mj: f64,
    /// The gathering unit with its memories.
    pub gathering_unit_mj: Option<f64>,
    /// Vector unit.
    pub vector_unit_mj: Option<f64>,
    /// The splat units with their memories; `None` where the configuration has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub splat_units_mj: Option<Option<f64>>,
    /// MAC array.
    pub array_mj: Option<f64>,
    /// Feature and weight buffers.
    pub buffers_mj: Option<f64>,
    /// Memory accesses, without those of DMA descriptors.
    pub memory_mj: f64,
    /// DMA descriptors, read from memory.
    pub dma_mj: f64,
    /// The interconnect.
    pub interconnect_mj: f64,
    /// Standby and refresh of memory.
    pub standby_mj: f64,
    /// Leakage of on-chip memories, logic and the array.
    pub leakage_mj: Option<f64>,
    /// The link.
    pub link_mj: f64,
}

impl EnergyByPart {
    /// Parts by name, those that the system has.
    #[must_use]
    pub fn named(&self) -> Vec<(&'static str, Option<f64>)> {
        let splat = self.splat_units_mj.map(|mj| ("splat units", mj));
        let units = [
            ("GPU", Some(self.gpu_mj)),
            ("gathering unit", self.gathering_unit_mj),
            ("vector unit", self.vector_unit_mj),
        ];
        let others = [
            ("MAC array", self.array_mj),
            ("buffers", self.buffers_mj),
            ("memory accesses", Some(self.memory_mj)),
            ("DMA descriptors", Some(self.dma_mj)),
            ("interconnect", Some(self.interconnect_mj)),
            ("memory standing by", Some(self.standby_mj)),
            ("leakage", self.leakage_mj),
            ("link", Some(self.link_mj)),
        ];
        units.into_iter().chain(splat).chain(others).collect()
    }

    /// Total energy in millijoules a frame; `None` where a part is not known.
    #[must_use]
    pub fn total_mj(&self) -> Option<f64> {
        self.named().iter().map(|(_, mj)| *mj).sum()
    }
}
