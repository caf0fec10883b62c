//! A GPU from counts: instructions, sectors of its cache, and bytes of memory, against what the
//! machine does at best; one factor each for fields, splats and whole pictures says what
//! programs reach.

use serde::{Deserialize, Serialize};

use super::work::FrameWork;

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
    /// Bytes of that cache.
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

/// Instructions, counted from the arithmetic: of a sample that is found (position, cell, test,
/// eight weights).
const INDEX: f64 = 40.0;
/// Of a vector that is read: its address and the loads' own.
const ADDRESS: f64 = 10.0;
/// Of a code that is interpolated: unpacked, multiplied and added.
const CODE: f64 = 2.0;
/// Of a Gaussian that is projected (covariance, conic, extent).
const PROJECT: f64 = 250.0;
/// Of a visible Gaussian's colour: 48 coefficients of spherical harmonics.
const HARMONICS: f64 = 150.0;
const COEFFICIENTS: f64 = 48.0;
/// Of a (tile, Gaussian) pair that is sorted: eight passes over keys of 64 bits.
const SORT: f64 = 8.0 * 12.0;
/// Bytes of a pair's key and value that a sort reads, and as many that it writes.
const SORT_BYTES: f64 = 8.0 * 12.0;
/// Of an element that the vector unit would compute (a part of a pixel's step).
const ELEMENT: f64 = 5.0;
/// Of a pixel that is warped: point, pose, projection, test, colour between four neighbours.
const WARP: f64 = 80.0;
/// Of a pixel that is scaled up: address, and four neighbours weighed in three colours.
const SCALE: f64 = 20.0;
/// Bytes of a colour and depth of 32 bits each: warping reads a reference's pixel, and writes and
/// reads a target's.
const WARP_BYTES: f64 = 16.0;
/// Bytes of a pixel that is shown: four, in memory.
pub(super) const PIXEL: f64 = 4.0;
/// Bytes of a parameter of a Gaussian.
const PARAMETER: f64 = 4.0;
/// Parameters of a Gaussian: mean, scales, rotation, opacity, 48 coefficients.
const PARAMETERS: f64 = 3.0 + 3.0 + 4.0 + 1.0 + COEFFICIENTS;
/// Bytes of a sector of the cache.
const SECTOR: f64 = 32.0;
/// Bytes a cycle of a multiprocessor's shared memory, and lanes of one.
const SHARED_BYTES: f64 = 128.0;
const LANES: f64 = 64.0;

/// What a kernel asks of a GPU.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Kernel {
    /// Instructions of all threads.
    pub instructions: f64,
    /// Bytes through the cache.
    pub cache_bytes: f64,
    /// Bytes through shared memory, those that wait for a bank counted as often as they wait.
    pub shared_bytes: f64,
    /// Bytes of memory that are read one behind the other.
    pub read_bytes: f64,
    /// Bytes of memory that are written so.
    pub written_bytes: f64,
    /// Bytes of memory that are read from anywhere.
    pub random_bytes: f64,
    /// Bytes of an access that does not stream.
    pub run_bytes: f64,
}

impl Kernel {
    /// A share of it.
    #[must_use]
    pub fn part(self, share: f64) -> Self {
        Self {
            read_bytes: self.read_bytes * share,
            written_bytes: self.written_bytes * share,
            random_bytes: self.random_bytes * share,
            ..self.times(share)
        }
    }

    /// The same, which writes so many bytes beside.
    #[must_use]
    pub fn writing(self, bytes: f64) -> Self {
        Self {
            written_bytes: self.written_bytes + bytes,
            ..self
        }
    }

    /// Bytes of memory.
    #[must_use]
    pub const fn memory_bytes(&self) -> f64 {
        self.read_bytes + self.written_bytes + self.random_bytes
    }

    /// As if it took so many times the work, with the same bytes of memory.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self {
            instructions: self.instructions * factor,
            cache_bytes: self.cache_bytes * factor,
            shared_bytes: self.shared_bytes * factor,
            ..self
        }
    }
}

/// What programs a GPU runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Program {
    /// Of a field.
    Fields,
    /// Of splats.
    Splats,
}

impl Program {
    /// Of a frame.
    #[must_use]
    pub const fn of(work: &FrameWork) -> Self {
        if work.gaussians > 0 {
            Self::Splats
        } else {
            Self::Fields
        }
    }
}

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
    /// (NVIDIA's Turing white paper). Efficiencies are those of the mobile GPU; its energy is not
    /// the device's.
    pub const RTX_2080_TI: Self = Self {
        cores: 4352.0,
        clock_ghz: 1.545,
        cache_gb_s: 68.0 * 64.0 * 1.545,
        cache_bytes: 5632 * 1024,
        memory_gb_s: Some(616.0),
        launch_us: 5.0,
        watts: 0.0,
        idle_watts: 0.0,
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
        self.ns(&warping(points), 1.0) / (ns - self.launch_ns())
    }

    /// Nanoseconds of a launch.
    #[must_use]
    pub const fn launch_ns(&self) -> f64 {
        self.launch_us * 1e3
    }
}

/// Finding where samples lie, or which tiles Gaussians touch and in which order.
#[must_use]
pub(super) fn indexing(work: &FrameWork) -> Kernel {
    let (gaussians, pairs) = (work.gaussians as f64, work.pairs as f64);
    // What is left out is neither read nor multiplied.
    let left_out = work.left_out_coefficients as f64;
    let parameters = gaussians * (PARAMETERS - left_out) * PARAMETER;
    let read = parameters + pairs * SORT_BYTES;
    let written = work.record_bytes as f64 + pairs * SORT_BYTES;
    Kernel {
        instructions: work.samples as f64 * INDEX
            + gaussians * PROJECT
            + work.visible as f64 * HARMONICS * (1.0 - left_out / COEFFICIENTS)
            + pairs * SORT,
        cache_bytes: read + written,
        read_bytes: read,
        written_bytes: written,
        ..Kernel::default()
    }
}

/// Gathering in pixel-centric order: every vector from the cache, what misses from anywhere.
#[must_use]
pub(super) fn gathering(work: &FrameWork) -> Kernel {
    let reads = &work.reads;
    Kernel {
        instructions: reads.reads as f64 * ADDRESS + reads.bytes as f64 / 2.0 * CODE,
        cache_bytes: reads.sectors as f64 * SECTOR,
        read_bytes: streaming(work) * reads.missed_bytes as f64,
        random_bytes: (1.0 - streaming(work)) * reads.missed_bytes as f64,
        run_bytes: reads.missed_bytes as f64 / reads.misses.max(1) as f64,
        ..Kernel::default()
    }
}

/// Share of the missed vectors that lie behind the one before.
fn streaming(work: &FrameWork) -> f64 {
    1.0 - work.reads.not_streaming as f64 / work.reads.misses.max(1) as f64
}

/// Gathering in memory-centric order without a unit for it: MVoxels come to shared memory, whose
/// banks hold whole vectors.
#[must_use]
pub(super) fn streamed_gathering(work: &FrameWork) -> Kernel {
    let total = work.total();
    let (rows, scattered) = (total.row_bytes as f64, work.scattered_bytes as f64);
    let table = total.rit_bytes as f64;
    let read = 2.0 * total.codes_read as f64;
    let vectors = total.codes_read as f64 / channels(work);
    Kernel {
        instructions: vectors * ADDRESS + total.codes_read as f64 * CODE,
        cache_bytes: rows + table,
        shared_bytes: read / (1.0 - work.reads.conflict_rate).max(1e-3),
        read_bytes: rows - scattered + table + work.spilled_bytes as f64 / 2.0,
        written_bytes: work.spilled_bytes as f64 / 2.0,
        random_bytes: scattered,
        run_bytes: work.reads.bytes as f64 / work.reads.reads.max(1) as f64,
    }
}

/// Channels of a vector, on average.
fn channels(work: &FrameWork) -> f64 {
    (work.reads.bytes as f64 / 2.0 / work.reads.reads.max(1) as f64).max(1.0)
}

/// Computing features on the GPU itself, as where there is no accelerator.
#[must_use]
pub(super) fn computation(work: &FrameWork) -> Kernel {
    let total = work.total();
    Kernel {
        instructions: total.macs as f64 + total.elements as f64 * ELEMENT,
        cache_bytes: total.feature_bytes as f64,
        ..Kernel::default()
    }
}

/// Warping a frame of so many pixels.
#[must_use]
pub(super) fn warping(pixels: u64) -> Kernel {
    let pixels = pixels as f64;
    Kernel {
        instructions: pixels * WARP,
        cache_bytes: pixels * (3.0 * WARP_BYTES + PIXEL),
        read_bytes: pixels * 2.0 * WARP_BYTES,
        written_bytes: pixels * (WARP_BYTES + PIXEL),
        ..Kernel::default()
    }
}

/// Scaling a frame up to so many pixels from half its width and height: of each, four neighbours
/// are read through the cache.
#[must_use]
pub(super) fn scaling(pixels: u64) -> Kernel {
    let pixels = pixels as f64;
    Kernel {
        instructions: pixels * SCALE,
        cache_bytes: pixels * 5.0 * PIXEL,
        read_bytes: pixels / 4.0 * PIXEL,
        written_bytes: pixels * PIXEL,
        ..Kernel::default()
    }
}
