//! GPU-only baseline: a frame on a GPU without accelerator.

use serde::Serialize;

use super::gpu::Gpu;
use super::kernels::{Instructions, Kernel, Program};
use super::memory::Memory;
use super::work::FrameWork;

/// Nanoseconds of a frame on the GPU alone, in pixel-centric order, by stage.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct GpuOnlyTime {
    /// Finding samples; or projecting and sorting Gaussians.
    pub indexing_ns: f64,
    /// Reading and interpolating feature vectors.
    pub gathering_ns: f64,
    /// Computing on features: perceptrons or products, and compositing.
    pub computation_ns: f64,
}

impl GpuOnlyTime {
    /// Total nanoseconds.
    #[must_use]
    pub const fn total_ns(&self) -> f64 {
        self.indexing_ns + self.gathering_ns + self.computation_ns
    }
}

/// Time of a frame on the GPU alone. Without dedicated memory, the GPU has the system's memory to
/// itself.
#[must_use]
pub fn gpu_only(
    gpu: &Gpu,
    instructions: &Instructions,
    memory: &Memory,
    work: &FrameWork,
) -> GpuOnlyTime {
    let ns = |reached: f64, kernel: Kernel| {
        let bytes = match gpu.memory_gb_s {
            Some(_) => 0.0,
            None => {
                kernel.read_bytes * memory.streamed().ns
                    + kernel.written_bytes * memory.written().ns
                    + kernel.random_bytes * memory.random(kernel.run_bytes).ns
            }
        };
        gpu.ns(&kernel, reached).max(bytes) + gpu.launch_ns()
    };
    let gathers = gpu.reached_gathering_by(Program::that_gathers(work));
    GpuOnlyTime {
        indexing_ns: ns(
            gpu.reached_by(Program::of(work)),
            instructions.indexing(work),
        ),
        gathering_ns: ns(gathers, instructions.gathering(work)),
        computation_ns: (instructions.computation(work))
            .map(|(program, kernel)| ns(gpu.reached_by(program), kernel))
            .sum(),
    }
}
