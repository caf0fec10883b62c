//! A frame's work as kernels of our own program for the GPU: fused, launched from C++, with
//! feature vectors as the accelerator stores them.
//!
//! Splats are prepared and blended as in the published rasterizer
//! ([`Splatting`]). Fields are marched as in torch-ngp and ngp_pl ([`march`]), gather packed
//! vectors of half precision, and run fused layers on the tensor cores. Instructions of a thread
//! are counted from its arithmetic; 32 threads are an instruction of a warp.

use potamoi_gpu::Kernel;
use potamoi_gpu::programs::{Host, Splatting, march};

use super::gpu_work::GpuWork;
use super::work::FrameWork;

/// Lanes of a warp, and bytes of a line and of a sector.
const WARP: f64 = 32.0;
const LINE: f64 = 128.0;
const SECTOR: f64 = 32.0;
/// Bytes of a displayed pixel in memory.
pub(super) const PIXEL: f64 = 4.0;
/// Bytes of a colour and depth of 32 bits each. Warping reads a reference's pixel, and writes and
/// reads a target's.
const WARP_BYTES: f64 = 16.0;
/// Coefficients of a Gaussian's colour, their bytes, and instructions of a thread for all.
const COEFFICIENTS: f64 = 48.0;
const PARAMETER: f64 = 4.0;
const HARMONICS: f64 = 150.0;
/// Instructions of a thread: the eight weights of a sample, with their quantisation.
const WEIGHTS: f64 = 24.0;
/// Reading a vector: its address; and each load of up to 16 bytes.
const VECTOR: f64 = 6.0;
const LOAD: f64 = 1.0;
const LOAD_BYTES: f64 = 16.0;
/// Interpolating two codes of half precision: a multiply-add of two.
const PAIR_OF_CODES: f64 = 1.0;
/// One element of a vector operation: part of a pixel's step.
const ELEMENT: f64 = 5.0;
/// Warping a pixel: point, pose, projection, test, bilinear colour.
const WARPED: f64 = 80.0;
/// Upscaling a pixel: address, and four neighbours weighted in three colours.
const SCALED: f64 = 20.0;
/// Lines, and sectors, of a request of 32 lanes of neighbouring pixels to one corner: assumed, the
/// likely count of `sim/gpu/rows` (6 to 15 lines, 7.5 to 16 sectors of entries of 4 bytes).
const LINES: f64 = 8.0;
const SECTORS: f64 = 9.5;
/// Counts of splats that are not made here, assumed: the likely ones of objects in `sim/gpu/rows`
/// (walked 0.76 to 0.97, blending 0.16 to 0.24, longest tile 3.6 to 10.9 times the mean).
const WALKED: f64 = 0.87;
const BLENDING: f64 = 0.2;
const LONGEST: f64 = 5.3;

/// Class of scenes, which decides what the units do and what energy their work takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Program {
    /// Fields: sampling, interpolation of tables, perceptrons.
    Fields,
    /// Splats: projection, sorting and compositing of Gaussians.
    Splats,
}

impl Program {
    /// The class of a frame.
    #[must_use]
    pub const fn of(work: &FrameWork) -> Self {
        if work.gaussians > 0 {
            Self::Splats
        } else {
            Self::Fields
        }
    }
}

/// A kernel of so many threads' instructions: half of them multiply-adds, a third integer.
fn computing(name: &'static str, instructions: f64) -> Kernel {
    let warps = instructions / WARP;
    Kernel {
        instructions: warps,
        fp32: warps * 0.5,
        int: warps * 0.33,
        ..Kernel::new(name)
    }
}

/// Streams these bytes through the caches, neighbours side by side.
fn through(bytes: f64, kernel: Kernel) -> Kernel {
    Kernel {
        l1_lines: bytes / LINE,
        l2_bytes: bytes,
        ..kernel
    }
}

/// Counts of a frame of splats for our own program: the published rasterizer, with a test of each pair
/// if the configuration asks for it. Pairs that are left out blend nowhere.
pub(super) fn splatting(work: &FrameWork) -> Splatting {
    let published = published_splatting(work);
    let (pairs, tested) = (work.pairs as f64, work.pairs_tested as f64);
    Splatting {
        pairs,
        tested,
        blending: (BLENDING * published.pairs / pairs.max(1.0)).min(1.0),
        ..published
    }
}

/// Counts of a frame of splats for the published rasterizer, which lists all pairs of the profile.
pub(super) fn published_splatting(work: &FrameWork) -> Splatting {
    let side = (work.pixels as f64).sqrt();
    Splatting {
        gaussians: work.gaussians as f64,
        visible: work.visible as f64,
        pairs: work.pairs.max(work.pairs_tested) as f64,
        width: side,
        height: side,
        walked: WALKED,
        blending: BLENDING,
        longest: LONGEST,
        ..Splatting::blank(Host::Viewer)
    }
}

/// Indexing: finding samples and their weights, or finding the tiles of Gaussians and their order.
#[must_use]
pub(super) fn indexing(work: &FrameWork) -> GpuWork {
    if work.gaussians == 0 {
        let marched = march(work.samples as f64);
        let weights = samples_gathered(work) * WEIGHTS / WARP;
        let kernel = Kernel {
            instructions: marched.instructions + weights,
            fp32: marched.fp32 + weights,
            ..marched
        };
        return GpuWork::streaming(kernel, 0.0, 0.0);
    }
    let splats = splatting(work);
    let mut kernels = splats.preparation();
    // What is left out is neither read nor multiplied.
    let left_out = work.left_out_coefficients as f64;
    if let Some(projection) = kernels.first_mut() {
        let bytes = splats.visible * left_out * PARAMETER;
        projection.instructions -= splats.gaussians / WARP * HARMONICS * left_out / COEFFICIENTS;
        projection.dram_bytes -= bytes;
        projection.l2_bytes -= bytes;
    }
    let moved: f64 = kernels.iter().map(|k| k.dram_bytes).sum();
    let written = splats.preparation_writes();
    let own = GpuWork {
        kernels,
        read_bytes: moved - written,
        written_bytes: written,
        ..GpuWork::default()
    };
    own.writing(work.record_bytes as f64)
}

/// Samples of a field that are gathered in pixel-centric order: vectors read, over those of a
/// sample, which are known from the entries of memory-centric order.
pub(super) fn samples_gathered(work: &FrameWork) -> f64 {
    let total = work.total();
    let vertices = total.codes_read as f64 / total.entries.max(1) as f64 / channels(work);
    work.reads.reads as f64 / vertices.max(1.0) / work.reads.tables.max(1) as f64
}

/// Instructions of threads that read vectors and interpolate their codes.
fn interpolation(vectors: f64, bytes: f64) -> f64 {
    let loads = loads(vectors, bytes);
    vectors * VECTOR + loads * LOAD + bytes / 4.0 * PAIR_OF_CODES
}

/// Loads of up to 16 bytes.
fn loads(vectors: f64, bytes: f64) -> f64 {
    vectors * (bytes / vectors.max(1.0) / LOAD_BYTES).ceil().max(1.0)
}

/// Gathering in pixel-centric order: each vector comes from the caches, and misses are random.
/// Neighbouring rays share corners. Lanes of splats read records that lie anywhere.
#[must_use]
pub(super) fn gathering(work: &FrameWork) -> GpuWork {
    let reads = &work.reads;
    let (vectors, bytes) = (reads.reads as f64, reads.bytes as f64);
    let requests = loads(vectors, bytes) / WARP;
    let sectors = reads.sectors as f64;
    let (lines, sectors) = match Program::of(work) {
        Program::Splats => (requests * WARP, sectors),
        Program::Fields => (
            requests * LINES,
            // Large vectors have sectors of their own.
            (vectors / WARP * SECTORS).max(sectors * LINES / WARP),
        ),
    };
    let kernel = Kernel {
        l1_lines: lines,
        l2_bytes: sectors * SECTOR,
        ..computing("gather", interpolation(vectors, bytes))
    };
    let missed = misses(work);
    GpuWork {
        kernels: vec![Kernel {
            dram_bytes: missed.memory_bytes(),
            ..kernel
        }],
        ..missed
    }
}

/// Gathering in memory-centric order without a gathering unit: `MVoxel`s are loaded into shared
/// memory, whose banks hold whole vectors.
#[must_use]
pub(super) fn streamed_gathering(work: &FrameWork) -> GpuWork {
    let total = work.total();
    let (rows, scattered) = (total.row_bytes as f64, work.scattered_bytes as f64);
    let table = total.rit_bytes as f64;
    let read = 2.0 * total.codes_read as f64;
    let vectors = total.codes_read as f64 / channels(work);
    let passes = read / LINE / (1.0 - work.reads.conflict_rate).max(1e-3);
    let moved = through(rows + table, computing("", interpolation(vectors, read)));
    let kernel = Kernel {
        name: "gather MVoxels",
        l1_lines: moved.l1_lines + rows / LINE + passes,
        dram_bytes: rows + table + work.spilled_bytes as f64,
        ..moved
    };
    GpuWork {
        kernels: vec![kernel],
        read_bytes: rows - scattered + table + work.spilled_bytes as f64 / 2.0,
        written_bytes: work.spilled_bytes as f64 / 2.0,
        random_bytes: scattered,
        run_bytes: work.reads.bytes as f64 / work.reads.reads.max(1) as f64,
    }
}

/// Computation without accelerator: fused layers in half precision, blended Gaussians, or what
/// compositing does on elements. Features stay on chip.
pub(super) fn computation(work: &FrameWork) -> Vec<Kernel> {
    let total = work.total();
    let shown = work.pixels as f64 * PIXEL;
    let layers = Kernel {
        tensor_flops: 2.0 * total.macs as f64,
        l1_lines: total.feature_bytes as f64 / LINE,
        ..Kernel::new("fused layers")
    };
    match Program::of(work) {
        Program::Fields => {
            let composite = through(
                shown,
                computing("composite", total.elements as f64 * ELEMENT),
            );
            let composite = Kernel {
                dram_bytes: shown,
                ..composite
            };
            vec![layers, composite]
        }
        // Colours that are a field have layers as well.
        Program::Splats if has_field_of_colours(work) => vec![layers, splatting(work).render()],
        Program::Splats => vec![splatting(work).render()],
    }
}

/// Whether a Gaussian's colour is a field (Compact-3DGS): a record is then about a hundred
/// interpolated vectors.
pub(super) const fn has_field_of_colours(work: &FrameWork) -> bool {
    work.gaussians > 0 && work.reads.tables > 1
}

/// Warping a frame of `pixels`: points are projected, then what they hit is resolved.
#[must_use]
pub(super) fn warping(pixels: u64) -> GpuWork {
    let pixels = pixels as f64;
    let kernel = through(
        pixels * (3.0 * WARP_BYTES + PIXEL),
        computing("warp", pixels * WARPED),
    );
    let kernel = Kernel {
        operations: 2.0,
        sfu: pixels * 2.0 / WARP,
        ..kernel
    };
    let (read, written) = (2.0 * WARP_BYTES, WARP_BYTES + PIXEL);
    GpuWork::streaming(kernel, pixels * read, pixels * written)
}

/// Upscaling a frame to `pixels` from half its width and height: each reads four neighbours
/// through the cache.
#[must_use]
pub(super) fn scaling(pixels: u64) -> GpuWork {
    let pixels = pixels as f64;
    let kernel = through(pixels * 5.0 * PIXEL, computing("scale", pixels * SCALED));
    GpuWork::streaming(kernel, pixels / 4.0 * PIXEL, pixels * PIXEL)
}

/// Memory traffic of gathering in pixel-centric order.
#[must_use]
pub(super) fn misses(work: &FrameWork) -> GpuWork {
    let reads = &work.reads;
    // Vectors that do not lie behind the one before.
    let elsewhere = reads.not_streaming as f64 / reads.misses.max(1) as f64;
    GpuWork {
        read_bytes: (1.0 - elsewhere) * reads.missed_bytes as f64,
        random_bytes: elsewhere * reads.missed_bytes as f64,
        run_bytes: reads.missed_bytes as f64 / reads.misses.max(1) as f64,
        ..GpuWork::default()
    }
}

/// Mean channels of a vector.
fn channels(work: &FrameWork) -> f64 {
    (work.reads.bytes as f64 / 2.0 / work.reads.reads.max(1) as f64).max(1.0)
}
