//! A frame's work as GPU kernels: instructions and bytes of cache, shared memory and memory.

use serde::{Deserialize, Serialize};

use super::work::FrameWork;

/// Instructions of GPU programs, counted from the arithmetic of each. They are not measured:
/// efficiencies are calibrated with these values.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Instructions {
    /// Finding a sample: position, cell, test, eight weights.
    pub sample: f64,
    /// Reading a vector: its address and the loads themselves.
    pub vector: f64,
    /// Interpolating a code: unpack, multiply and add.
    pub code: f64,
    /// Projecting a Gaussian: covariance, conic, extent.
    pub projected: f64,
    /// Colour of a visible Gaussian with 48 coefficients of spherical harmonics.
    pub harmonics: f64,
    /// Sorting a (tile, Gaussian) pair: eight passes over keys of 64 bits.
    pub sorted: f64,
    /// One element of a vector operation: part of a pixel's step.
    pub element: f64,
    /// Warping a pixel: point, pose, projection, test, bilinear colour.
    pub warped: f64,
    /// Upscaling a pixel: address, and four neighbours weighted in three colours.
    pub scaled: f64,
}

impl Default for Instructions {
    fn default() -> Self {
        Self {
            sample: 40.0,
            vector: 10.0,
            code: 2.0,
            projected: 250.0,
            harmonics: 150.0,
            sorted: 8.0 * 12.0,
            element: 5.0,
            warped: 80.0,
            scaled: 20.0,
        }
    }
}

/// Coefficients of a colour.
const COEFFICIENTS: f64 = 48.0;
/// Bytes of a pair's key and value that a sort reads, and again writes, in all passes.
const SORT_BYTES: f64 = 8.0 * 12.0;
/// Bytes of a colour and depth of 32 bits each. Warping reads a reference's pixel, and writes and
/// reads a target's.
const WARP_BYTES: f64 = 16.0;
/// Bytes of a displayed pixel in memory.
pub(super) const PIXEL: f64 = 4.0;
/// Bytes of a parameter of a Gaussian.
const PARAMETER: f64 = 4.0;
/// Parameters of a Gaussian: mean, scales, rotation, opacity, 48 coefficients.
const PARAMETERS: f64 = 3.0 + 3.0 + 4.0 + 1.0 + COEFFICIENTS;
/// Bytes of a sector of the cache.
const SECTOR: f64 = 32.0;

/// Demands of a kernel.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Kernel {
    /// Instructions of all threads.
    pub instructions: f64,
    /// Bytes through the cache.
    pub cache_bytes: f64,
    /// Bytes through shared memory; those that wait for a bank count again for each wait.
    pub shared_bytes: f64,
    /// Bytes read sequentially from memory.
    pub read_bytes: f64,
    /// Bytes written sequentially to memory.
    pub written_bytes: f64,
    /// Bytes read at random from memory.
    pub random_bytes: f64,
    /// Bytes of a random access.
    pub run_bytes: f64,
}

impl Kernel {
    /// A share of the kernel.
    #[must_use]
    pub fn part(self, share: f64) -> Self {
        Self {
            instructions: self.instructions * share,
            cache_bytes: self.cache_bytes * share,
            shared_bytes: self.shared_bytes * share,
            read_bytes: self.read_bytes * share,
            written_bytes: self.written_bytes * share,
            random_bytes: self.random_bytes * share,
            run_bytes: self.run_bytes,
        }
    }

    /// The kernel with further bytes written.
    #[must_use]
    pub fn writing(self, bytes: f64) -> Self {
        Self {
            written_bytes: self.written_bytes + bytes,
            ..self
        }
    }

    /// Bytes of memory, read and written.
    #[must_use]
    pub const fn memory_bytes(&self) -> f64 {
        self.read_bytes + self.written_bytes + self.random_bytes
    }
}

/// Class of GPU programs, which sets the efficiency.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Program {
    /// Field programs: sampling, interpolation of tables, perceptrons.
    Fields,
    /// Splat programs: projection, sorting and compositing of Gaussians.
    Splats,
}

impl Program {
    /// The program that indexes a frame: finds samples, or projects and sorts.
    #[must_use]
    pub const fn of(work: &FrameWork) -> Self {
        if work.gaussians > 0 {
            Self::Splats
        } else {
            Self::Fields
        }
    }

    /// The program that gathers. Where Gaussians' colours are a field (Compact-3DGS), that of
    /// fields: a record is then about a hundred interpolated vectors.
    #[must_use]
    pub(crate) const fn that_gathers(work: &FrameWork) -> Self {
        if work.gaussians > 0 && work.reads.tables <= 1 {
            Self::Splats
        } else {
            Self::Fields
        }
    }
}

impl Instructions {
    /// Indexing: finding samples, or finding the tiles of Gaussians and their order.
    #[must_use]
    pub(super) fn indexing(&self, work: &FrameWork) -> Kernel {
        let (gaussians, pairs) = (work.gaussians as f64, work.pairs as f64);
        // What is left out is neither read nor multiplied.
        let left_out = work.left_out_coefficients as f64;
        let parameters = gaussians * (PARAMETERS - left_out) * PARAMETER;
        let read = parameters + pairs * SORT_BYTES;
        let written = work.record_bytes as f64 + pairs * SORT_BYTES;
        Kernel {
            instructions: work.samples as f64 * self.sample
                + gaussians * self.projected
                + work.visible as f64 * self.harmonics * (1.0 - left_out / COEFFICIENTS)
                + pairs * self.sorted,
            cache_bytes: read + written,
            read_bytes: read,
            written_bytes: written,
            ..Kernel::default()
        }
    }

    /// Gathering in pixel-centric order: each vector comes from the cache, and misses are random.
    #[must_use]
    pub(super) fn gathering(&self, work: &FrameWork) -> Kernel {
        let reads = &work.reads;
        Kernel {
            instructions: reads.reads as f64 * self.vector + reads.bytes as f64 / 2.0 * self.code,
            cache_bytes: reads.sectors as f64 * SECTOR,
            ..misses(work)
        }
    }

    /// Gathering in memory-centric order without a gathering unit: `MVoxel`s are loaded into shared
    /// memory, whose banks hold whole vectors.
    #[must_use]
    pub(super) fn streamed_gathering(&self, work: &FrameWork) -> Kernel {
        let total = work.total();
        let (rows, scattered) = (total.row_bytes as f64, work.scattered_bytes as f64);
        let table = total.rit_bytes as f64;
        let read = 2.0 * total.codes_read as f64;
        let vectors = total.codes_read as f64 / channels(work);
        Kernel {
            instructions: vectors * self.vector + total.codes_read as f64 * self.code,
            cache_bytes: rows + table,
            shared_bytes: read / (1.0 - work.reads.conflict_rate).max(1e-3),
            read_bytes: rows - scattered + table + work.spilled_bytes as f64 / 2.0,
            written_bytes: work.spilled_bytes as f64 / 2.0,
            random_bytes: scattered,
            run_bytes: work.reads.bytes as f64 / work.reads.reads.max(1) as f64,
        }
    }

    /// Computation without accelerator: perceptrons or a splat's products, and vector operations,
    /// each with the program that does it. One kernel where both programs are the same.
    pub(super) fn computation(&self, work: &FrameWork) -> impl Iterator<Item = (Program, Kernel)> {
        let total = work.total();
        let products = Kernel {
            instructions: total.macs as f64,
            cache_bytes: total.feature_bytes as f64,
            ..Kernel::default()
        };
        let elements = total.elements as f64 * self.element;
        let (own, other) = (Program::that_gathers(work), Program::of(work));
        let together = Kernel {
            instructions: products.instructions + elements,
            ..products
        };
        let alone = Kernel {
            instructions: elements,
            ..Kernel::default()
        };
        let all = match own == other {
            true => [Some((own, together)), None],
            false => [Some((own, products)), Some((other, alone))],
        };
        all.into_iter().flatten()
    }

    /// Warping a frame of `pixels`.
    #[must_use]
    pub(super) fn warping(&self, pixels: u64) -> Kernel {
        let pixels = pixels as f64;
        Kernel {
            instructions: pixels * self.warped,
            cache_bytes: pixels * (3.0 * WARP_BYTES + PIXEL),
            read_bytes: pixels * 2.0 * WARP_BYTES,
            written_bytes: pixels * (WARP_BYTES + PIXEL),
            ..Kernel::default()
        }
    }

    /// Upscaling a frame to `pixels` from half its width and height: each reads four neighbours
    /// through the cache.
    #[must_use]
    pub(super) fn scaling(&self, pixels: u64) -> Kernel {
        let pixels = pixels as f64;
        Kernel {
            instructions: pixels * self.scaled,
            cache_bytes: pixels * 5.0 * PIXEL,
            read_bytes: pixels / 4.0 * PIXEL,
            written_bytes: pixels * PIXEL,
            ..Kernel::default()
        }
    }
}

/// Memory traffic of gathering in pixel-centric order.
#[must_use]
pub(super) fn misses(work: &FrameWork) -> Kernel {
    let reads = &work.reads;
    // Vectors that do not lie behind the one before.
    let elsewhere = reads.not_streaming as f64 / reads.misses.max(1) as f64;
    Kernel {
        read_bytes: (1.0 - elsewhere) * reads.missed_bytes as f64,
        random_bytes: elsewhere * reads.missed_bytes as f64,
        run_bytes: reads.missed_bytes as f64 / reads.misses.max(1) as f64,
        ..Kernel::default()
    }
}

/// Mean channels of a vector.
fn channels(work: &FrameWork) -> f64 {
    (work.reads.bytes as f64 / 2.0 / work.reads.reads.max(1) as f64).max(1.0)
}
