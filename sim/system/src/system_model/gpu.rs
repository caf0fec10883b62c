//! Roofline model of a GPU: instructions, cache sectors and memory bytes at peak rates, times an
//! efficiency. Fields, splats and whole pictures have an efficiency each.

use serde::{Deserialize, Serialize};

use super::kernels::{Instructions, Kernel, Program};

/// Parameters of a GPU.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gpu {
    /// Lanes, each one instruction a cycle.
    pub cores: f64,
    /// Clock in gigahertz.
    pub clock_ghz: f64,
    /// Bandwidth of the second-level cache in GB/s: 64 bytes a cycle for each multiprocessor of 64
    /// lanes.
    pub cache_gb_s: f64,
    /// Bytes of that cache. Misses are counted for the device's cache.
    pub cache_bytes: u32,
    /// Bandwidth of dedicated memory in GB/s; `None` where the GPU shares the system's. The energy
    /// of dedicated memory is part of `watts`.
    pub memory_gb_s: Option<f64>,
    /// Microseconds of a kernel launch.
    pub launch_us: f64,
    /// Power at work, in watts.
    pub watts: f64,
    /// Idle power, in watts.
    pub idle_watts: f64,
    /// Slowdown of gathering beyond its efficiency; 1 unless a program is known to gather worse
    /// than it computes.
    pub gathering_factor: f64,
    /// Efficiency of field programs, as a share of peak. Calibrated.
    pub fields_efficiency: f64,
    /// Efficiency of splat programs, as a share of peak. Calibrated.
    pub splats_efficiency: f64,
    /// Efficiency of programs that pass once over a picture, warping and scaling, as a share of
    /// peak. Calibrated.
    pub pictures_efficiency: f64,
}

/// Bytes a cycle of a multiprocessor's shared memory, and its lanes.
const SHARED_BYTES: f64 = 128.0;
const LANES: f64 = 64.0;

impl Gpu {
    /// The mobile Volta GPU of Xavier: 512 lanes, 1.377 GHz, 512 KB (paper; NVIDIA's data sheet).
    /// It shares the system's memory. Watts are an assumption: half of the module's 30 W mode.
    /// Efficiencies are calibrated by `potamoi model --calibrate`.
    pub(crate) const XAVIER: Self = Self {
        cores: 512.0,
        clock_ghz: 1.377,
        cache_gb_s: 8.0 * 64.0 * 1.377,
        cache_bytes: 512 * 1024,
        memory_gb_s: None,
        launch_us: 10.0,
        watts: 15.0,
        idle_watts: 1.0,
        gathering_factor: 1.0,
        fields_efficiency: 0.1042,
        splats_efficiency: 0.0113,
        pictures_efficiency: 0.1146,
    };

    /// The 2080 Ti of the paper's remote machine: 4352 lanes, 1.545 GHz, 5.5 MB, 616 GB/s (NVIDIA's
    /// Turing white paper). Efficiencies are those of the mobile GPU, an assumption. Power is the
    /// board's 250 W at work (ibid.) and 15 W idle, an assumption; neither counts as the device's.
    pub(crate) const RTX_2080_TI: Self = Self {
        cores: 4352.0,
        clock_ghz: 1.545,
        cache_gb_s: 68.0 * 64.0 * 1.545,
        cache_bytes: 5632 * 1024,
        memory_gb_s: Some(616.0),
        launch_us: 5.0,
        watts: 250.0,
        idle_watts: 15.0,
        ..Self::XAVIER
    };

    /// The same GPU with another efficiency of rendering programs.
    #[must_use]
    pub const fn reaching(self, efficiency: f64) -> Self {
        Self {
            fields_efficiency: efficiency,
            splats_efficiency: efficiency,
            pictures_efficiency: efficiency,
            ..self
        }
    }

    /// Efficiency of a rendering program.
    #[must_use]
    pub(crate) const fn reached_by(&self, program: Program) -> f64 {
        match program {
            Program::Fields => self.fields_efficiency,
            Program::Splats => self.splats_efficiency,
        }
    }

    /// Efficiency of a gathering program.
    #[must_use]
    pub(crate) const fn reached_gathering_by(&self, program: Program) -> f64 {
        self.reached_by(program) / self.gathering_factor
    }

    /// Nanoseconds of a kernel on its own at the given efficiency, without waits for shared memory.
    #[must_use]
    pub fn ns(&self, kernel: &Kernel, efficiency: f64) -> f64 {
        let shared = self.cores / LANES * SHARED_BYTES * self.clock_ghz;
        let own = (kernel.instructions / (self.cores * self.clock_ghz))
            .max(kernel.cache_bytes / self.cache_gb_s)
            .max(kernel.shared_bytes / shared)
            / efficiency;
        let memory = (self.memory_gb_s).map_or(0.0, |gb_s| kernel.memory_bytes() / gb_s);
        own.max(memory)
    }

    /// Efficiency at which `points` are warped in `ns` nanoseconds, launch included, if memory is
    /// no limit.
    #[must_use]
    pub fn efficiency_that_warps(&self, points: u64, ns: f64) -> f64 {
        let warping = Instructions::default().warping(points);
        self.ns(&warping, 1.0) / (ns - self.launch_ns())
    }

    /// Nanoseconds of a kernel launch.
    #[must_use]
    pub(crate) const fn launch_ns(&self) -> f64 {
        self.launch_us * 1e3
    }
}
