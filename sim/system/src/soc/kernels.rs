//! What a frame's work is to a GPU: instructions, bytes of its cache, of shared memory and of
//! memory, of each of its programs.

use serde::{Deserialize, Serialize};

use super::work::FrameWork;

/// Instructions of what programs do, counted from the arithmetic of each. No machine counted them:
/// efficiencies are calibrated with them as they are.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Instructions {
    /// Of a sample that is found: position, cell, test, eight weights.
    pub sample: f64,
    /// Of a vector that is read: its address and the loads' own.
    pub vector: f64,
    /// Of a code that is interpolated: unpacked, multiplied and added.
    pub code: f64,
    /// Of a Gaussian that is projected: covariance, conic, extent.
    pub projected: f64,
    /// Of a visible Gaussian's colour, if it has 48 coefficients of spherical harmonics.
    pub harmonics: f64,
    /// Of a (tile, Gaussian) pair that is sorted: eight passes over keys of 64 bits.
    pub sorted: f64,
    /// Of an element that the vector unit would compute: a part of a pixel's step.
    pub element: f64,
    /// Of a pixel that is warped: point, pose, projection, test, colour between four neighbours.
    pub warped: f64,
    /// Of a pixel that is scaled up: address, and four neighbours weighed in three colours.
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
/// Bytes of a pair's key and value that a sort reads, and as many that it writes.
const SORT_BYTES: f64 = 8.0 * 12.0;
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
            instructions: self.instructions * share,
            cache_bytes: self.cache_bytes * share,
            shared_bytes: self.shared_bytes * share,
            read_bytes: self.read_bytes * share,
            written_bytes: self.written_bytes * share,
            random_bytes: self.random_bytes * share,
            run_bytes: self.run_bytes,
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
}

/// What programs a GPU runs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Program {
    /// Of a field: samples are found, tables interpolated, perceptrons run.
    Fields,
    /// Of splats: Gaussians are projected, sorted and composited.
    Splats,
}

impl Program {
    /// That finds where a frame's samples lie, or projects and sorts.
    #[must_use]
    pub const fn of(work: &FrameWork) -> Self {
        if work.gaussians > 0 {
            Self::Splats
        } else {
            Self::Fields
        }
    }

    /// That gathers: of Gaussians whose colours are a field (Compact-3DGS) it interpolates
    /// tables, a hundred vectors of which come to one record.
    #[must_use]
    pub const fn that_gathers(work: &FrameWork) -> Self {
        if work.gaussians > 0 && work.reads.tables <= 1 {
            Self::Splats
        } else {
            Self::Fields
        }
    }
}

impl Instructions {
    /// Finding where samples lie, or which tiles Gaussians touch and in which order.
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

    /// Gathering in pixel-centric order: every vector from the cache, what misses from anywhere.
    #[must_use]
    pub(super) fn gathering(&self, work: &FrameWork) -> Kernel {
        let reads = &work.reads;
        Kernel {
            instructions: reads.reads as f64 * self.vector + reads.bytes as f64 / 2.0 * self.code,
            cache_bytes: reads.sectors as f64 * SECTOR,
            ..misses(work)
        }
    }

    /// Gathering in memory-centric order without a unit for it: `MVoxel`s come to shared memory,
    /// whose banks hold whole vectors.
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

    /// Computing features on the GPU itself, as where there is no accelerator: perceptrons or a
    /// splat's products, and what the vector unit would do, each with the program that does it.
    /// One kernel where that is the same.
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

    /// Warping a frame of so many pixels.
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

    /// Scaling a frame up to so many pixels from half its width and height: of each, four neighbours
    /// are read through the cache.
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

/// Bytes of memory that gathering in pixel-centric order asks for.
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

/// Channels of a vector, on average.
fn channels(work: &FrameWork) -> f64 {
    (work.reads.bytes as f64 / 2.0 / work.reads.reads.max(1) as f64).max(1.0)
}
