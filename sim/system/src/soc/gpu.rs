//! A GPU: instructions, sectors of its cache, and bytes of memory against what the machine does
//! at best; one factor each for fields, splats and whole pictures says what programs reach.

use serde::{Deserialize, Serialize};

use super::kernels::{Instructions, Kernel, Program};

/// A GPU.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gpu {
    /// Lanes, each an instruction a cycle.
    pub cores: f64,
    /// Cycles a nanosecond.
    pub clock_ghz: f64,
    /// Bytes a nanosecond of its second-level cache: 64 a cycle and multiprocessor of 64 lanes.
    pub cache_gb_s: f64,
    /// Bytes of that cache; counted are the misses of the device's.
    pub cache_bytes: u32,
    /// Bytes a nanosecond of a memory of its own; none where it shares the system's. The energy of a
    /// memory of its own is among its watts.
    pub memory_gb_s: Option<f64>,
    /// Microseconds to launch a kernel.
    pub launch_us: f64,
    /// Watts at work.
    pub watts: f64,
    /// Watts idle.
    pub idle_watts: f64,
    /// How many times longer gathering takes than by the same share of the best as all else. 1
    /// unless a program's gathering is known to be worse than its arithmetic.
    pub gathering_factor: f64,
    /// Share of the machine's best that programs for fields reach. Calibrated.
    pub fields_efficiency: f64,
    /// Share of the machine's best that programs for splats reach. Calibrated.
    pub splats_efficiency: f64,
    /// Share of the machine's best that programs reach that go through a picture once: warping and
    /// scaling. Calibrated.
    pub pictures_efficiency: f64,
}

/// Bytes a cycle of a multiprocessor's shared memory, and lanes of one.
const SHARED_BYTES: f64 = 128.0;
const LANES: f64 = 64.0;

impl Gpu {
    /// The mobile Volta GPU of Xavier: 512 lanes, 1.377 GHz, 512 KB (paper; NVIDIA's data
    /// sheet). It shares the system's memory. Watts are assumptions: half of the module's mode
    /// of 30 W. Efficiencies are calibrated by `potamoi model --calibrate`.
    pub const XAVIER: Self = Self {
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

    /// The 2080 Ti of the paper's remote machine: 4352 lanes, 1.545 GHz, 5.5 MB, 616 GB/s
    /// (NVIDIA's Turing white paper). Efficiencies are those of the mobile GPU, an assumption. At
    /// work it takes its board's 250 W (ibid.), idle 15 W, an assumption; neither is the device's.
    pub const RTX_2080_TI: Self = Self {
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

    /// The same with programs that reach such a share of its best.
    #[must_use]
    pub const fn reaching(self, efficiency: f64) -> Self {
        Self {
            fields_efficiency: efficiency,
            splats_efficiency: efficiency,
            pictures_efficiency: efficiency,
            ..self
        }
    }

    /// The share of its best that a program which renders reaches.
    #[must_use]
    pub const fn reached_by(&self, program: Program) -> f64 {
        match program {
            Program::Fields => self.fields_efficiency,
            Program::Splats => self.splats_efficiency,
        }
    }

    /// The same of one that gathers.
    #[must_use]
    pub const fn reached_gathering_by(&self, program: Program) -> f64 {
        self.reached_by(program) / self.gathering_factor
    }

    /// Nanoseconds of a kernel by itself at such a share of the best; memory that is shared with
    /// others is not in it.
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

    /// The share of its best at which points are warped in so many nanoseconds, its launch among
    /// them, where memory does not hold it up.
    #[must_use]
    pub fn efficiency_that_warps(&self, points: u64, ns: f64) -> f64 {
        let warping = Instructions::default().warping(points);
        self.ns(&warping, 1.0) / (ns - self.launch_ns())
    }

    /// Nanoseconds of a launch.
    #[must_use]
    pub const fn launch_ns(&self) -> f64 {
        self.launch_us * 1e3
    }
}
