//! Figures of a machine on a scene.

use potamoi_system::system_model::{
    AtBounds, BlockArea, ClockOrigin, Demand, GpuOnly, Outcome, Unknown,
};
use schemars::JsonSchema;
use serde::Serialize;

use crate::quality::PictureQuality;
use crate::workload::Fidelity;

/// What a machine does on a scene.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Figures {
    /// The machine's name.
    pub machine: String,
    /// Preset of its units, if they are one's.
    pub preset: Option<&'static str>,
    /// Its GPU.
    pub gpu: String,
    /// Its memory: name and channels.
    pub memory: (String, u32),
    /// Rows and columns of its array.
    pub array: [u32; 2],
    /// Bytes of its feature buffer and of its weight buffer.
    pub buffer_bytes: [u64; 2],
    /// The scene's name.
    pub scene: String,
    /// The model's algorithm.
    pub algorithm: String,
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Frames of the path.
    pub frames: u32,
    /// Variant of the system: how frames are rendered, and where features are gathered.
    pub variant: &'static str,
    /// Method of the times.
    pub fidelity: Fidelity,
    /// Clock of the accelerator in gigahertz, its origin, and the block that bounds it.
    pub clock_ghz: f64,
    /// Origin of the clock.
    pub clock_origin: ClockOrigin,
    /// Clock that the slowest block reaches, in gigahertz, whatever is assumed; `None` where no period is
    /// known.
    pub reached_ghz: Option<f64>,
    /// The slowest block of the accelerator.
    pub clock_bound_by: Option<String>,
    /// Frames a second.
    pub frames_per_second: AtBounds<f64>,
    /// Frames a second if the accelerator's units took no time.
    pub free_units_frames_per_second: AtBounds<f64>,
    /// Frames a second of full frames on the GPU alone, with its own memory, by a fused program.
    pub gpu_alone_frames_per_second: AtBounds<f64>,
    /// The resource or channel with the largest share of the time at both bounds, and that share;
    /// no share where demands alone are known.
    pub bottleneck: AtBounds<(&'static str, Option<f64>)>,
    /// Energy of the device in millijoules a frame; `None` where a part is not known.
    pub mj: Option<AtBounds<f64>>,
    /// Its GPU's part.
    pub gpu_mj: AtBounds<f64>,
    /// The part of units, array, on-chip buffers and leakage; `None` where one is not known.
    pub accelerator_mj: Option<AtBounds<f64>>,
    /// The part of memory and interconnect.
    pub memory_mj: AtBounds<f64>,
    /// Area of gathering unit, vector unit and splat units with their memories, in square millimetres
    /// at 12 nm before wires.
    pub units_mm2: Option<f64>,
    /// Area of all blocks of the accelerator.
    pub mm2: Option<f64>,
    /// Each block with its memories: units, MAC array and buffers.
    pub blocks: Vec<BlockArea>,
    /// Blocks whose energy or area is not known, and why.
    pub unknown: Vec<Unknown>,
    /// Quality of the frames; `None` where it was not asked for.
    pub quality: Option<PictureQuality>,
}

impl Figures {
    /// Milliseconds of a frame.
    #[must_use]
    pub fn frame_ms(&self) -> AtBounds<f64> {
        self.frames_per_second.map(|rate| 1e3 / rate)
    }

    /// Energy-delay product in millijoule milliseconds, at the geometric mean of both bounds.
    #[must_use]
    pub fn energy_delay(&self) -> Option<f64> {
        Some(self.mj?.mid() * self.frame_ms().mid())
    }
}

/// Times and energies, scheduled or not.
pub(crate) struct Timed {
    pub(crate) frames_per_second: AtBounds<f64>,
    pub(crate) free_units: AtBounds<f64>,
    pub(crate) bottleneck: AtBounds<(&'static str, Option<f64>)>,
    energy: AtBounds<potamoi_system::system_model::EnergyByPart>,
}

impl Timed {
    pub(crate) fn scheduled(outcome: &Outcome) -> Self {
        let run = &outcome.run;
        Self {
            frames_per_second: run.frames_per_second(),
            free_units: run.map(|run| run.frames as f64 / run.free_units_ns * 1e9),
            bottleneck: run.map(|run| {
                let (name, share) = run.bottleneck();
                (name, Some(share))
            }),
            energy: run.map(|run| run.energy),
        }
    }

    pub(crate) fn by_demand(demand: &AtBounds<Demand>) -> Self {
        Self {
            frames_per_second: demand.map(|own| 1e9 / own.span_ns),
            free_units: demand.map(|own| 1e9 / own.free_units_ns),
            bottleneck: demand.map(|own| (own.bottleneck, None)),
            energy: demand.map(|own| own.energy),
        }
    }

    pub(crate) fn mj(&self) -> Option<AtBounds<f64>> {
        let both = self.energy.max.total_mj().zip(self.energy.sum.total_mj());
        both.map(|(max, sum)| AtBounds { max, sum })
    }

    pub(crate) fn gpu_mj(&self) -> AtBounds<f64> {
        self.energy.map(|own| own.gpu_mj)
    }

    pub(crate) fn memory_mj(&self) -> AtBounds<f64> {
        self.energy
            .map(|own| own.memory_mj + own.dma_mj + own.interconnect_mj + own.standby_mj)
    }

    /// All that is neither the GPU's, the memory's nor the link's.
    pub(crate) fn accelerator_mj(&self) -> Option<AtBounds<f64>> {
        let (all, gpu, memory) = (self.mj()?, self.gpu_mj(), self.memory_mj());
        let link = self.energy.map(|own| own.link_mj);
        Some(AtBounds {
            max: all.max - gpu.max - memory.max - link.max,
            sum: all.sum - gpu.sum - memory.sum - link.sum,
        })
    }
}

/// Frames a second of the GPU alone.
pub(crate) fn alone(of: &GpuOnly) -> AtBounds<f64> {
    of.fused.frame_ns.map(|ns| 1e9 / ns)
}
