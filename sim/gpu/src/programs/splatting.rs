//! 3D Gaussian splatting: `diff-gaussian-rasterization` and what calls it.
//!
//! Source: graphdeco-inria, `cuda_rasterizer/rasterizer_impl.cu` (`Rasterizer::forward`),
//! `forward.cu`, and `gaussian_renderer/__init__.py` (`render`).

use super::{Count, Program, counts};
use crate::frame::Launch;
use crate::kernel::{LINE, WARP};
use crate::operations::elementwise;
use crate::{Device, Frame, Kernel};

/// Side of a tile in pixels, and warps of its block.
const TILE: f64 = 16.0;
const BLOCK_WARPS: f64 = 8.0;
/// Bits of a sorting pass, and of a depth (`cub::DeviceRadixSort`, policies 700 and 800).
const DIGIT_BITS: f64 = 8.0;
const DEPTH_BITS: f64 = 32.0;
/// Clocks of an entry for one warp alone, in order: two loads of shared memory, the quadratic
/// form, an exponential and the product wait for each other.
const ENTRY_CLOCKS: f64 = 110.0;
/// Pairs of the longest lane of a warp over the mean, where a lane takes all pairs of its Gaussian.
const LONGEST_LANE: f64 = 4.0;

/// Test of a (tile, Gaussian) pair, derived from its steps in `golden/splats/src/tile_test.rs`: is the
/// smallest `p^2 + q^2` over the tile's pixels within the opacity's limit?
///
/// | step | FMA pipe | ALU pipe |
/// |---|---|---|
/// | sides x0, x1, y0, y1: two places, two held within the picture | 4 | 2 |
/// | x and y of the rectangle nearest to the mean: two of min and max each | | 4 |
/// | nearest place on each of the two sides: a product, min and max | 2 | 4 |
/// | p, q and `p^2 + q^2` at both: two products and a multiply-add, a product and a multiply-add | 10 | |
/// | the smaller, and whether it is within the limit | | 2 |
const TEST: Instructions = Instructions {
    fp32: 16.0,
    int: 12.0,
    sfu: 0.0,
};
/// Loop over the tiles of a Gaussian that counts them: two increments, a comparison and a branch.
const COUNTING: f64 = 4.0;
/// Values of a Gaussian for its tests: limit of the opacity from two words of 80 (10), its square root
/// and what rounding adds (16), two slopes with a division of about 10 each (23), and floats from codes
/// (15).
const TESTED_GAUSSIAN: Instructions = Instructions {
    fp32: 40.0,
    int: 15.0,
    sfu: 9.0,
};

/// Instructions of a thread, by pipe.
struct Instructions {
    fp32: f64,
    int: f64,
    sfu: f64,
}

impl Instructions {
    /// A kernel with `warps` times these instructions besides its own.
    fn times(&self, warps: f64, own: Kernel) -> Kernel {
        Kernel {
            instructions: own.instructions + warps * (self.fp32 + self.int + self.sfu),
            fp32: own.fp32 + warps * self.fp32,
            int: own.int + warps * self.int,
            sfu: own.sfu + warps * self.sfu,
            ..own
        }
    }
}

/// Who calls the rasterizer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Host {
    /// The paper's viewer, from C++; activated parameters lie ready.
    Viewer,
    /// The Python binding alone; activated parameters lie ready.
    Rasterizer,
    /// `render()`, which activates and concatenates all parameters each frame.
    Render,
}

/// Counts of a frame of 3D Gaussians.
#[derive(Debug, Clone, PartialEq)]
pub struct Splatting {
    /// Who calls.
    pub host: Host,
    /// Gaussians of the model.
    pub gaussians: f64,
    /// Gaussians that touch a tile.
    pub visible: f64,
    /// Pairs of a Gaussian and a tile: entries that are sorted.
    pub pairs: f64,
    /// Pairs that are tested before, of which [`Splatting::pairs`] are left; 0 in the published program,
    /// which tests none.
    pub tested: f64,
    /// Width of the picture in pixels.
    pub width: f64,
    /// Height of the picture in pixels.
    pub height: f64,
    /// Share of pairs and warps walked before all pixels of the warp are opaque.
    pub walked: f64,
    /// Share of those in which at least one lane blends.
    pub blending: f64,
    /// Entries of the longest tile over the mean.
    pub longest: f64,
}

impl Splatting {
    /// All counts zero.
    #[must_use]
    pub const fn blank(host: Host) -> Self {
        Self {
            host,
            gaussians: 0.0,
            visible: 0.0,
            pairs: 0.0,
            tested: 0.0,
            width: 0.0,
            height: 0.0,
            walked: 0.0,
            blending: 0.0,
            longest: 0.0,
        }
    }

    /// Operations before rendering: projection, pairs of Gaussians and tiles, sorting.
    #[must_use]
    pub fn preparation(&self) -> Vec<Kernel> {
        let mut kernels = vec![self.preprocess(), self.scan(), self.duplicate()];
        kernels.extend(self.sort());
        kernels.push(self.ranges());
        kernels
    }

    /// Bytes that preparation writes to the memory, of all that it moves: radii and counts, what
    /// is projected, sums, and pairs as they are made and in each pass of sorting.
    #[must_use]
    pub fn preparation_writes(&self) -> f64 {
        let passes = self.sort().len() as f64 - 1.0;
        self.gaussians * 12.0 + self.visible * 47.0 + self.pairs * 12.0 * (1.0 + passes)
    }

    fn tiles(&self) -> f64 {
        (self.width / TILE).ceil() * (self.height / TILE).ceil()
    }

    /// Operations of Python around the rasterizer.
    fn python(&self, device: &Device) -> Vec<Kernel> {
        let gaussians = self.gaussians;
        // Binding: outputs and buffers are allocated, radii and gradients of means zeroed.
        let binding = elementwise("binding: allocate, zero", gaussians, 30.0, 12.0, device);
        if self.host == Host::Rasterizer {
            return vec![binding];
        }
        vec![
            // exp of 3, sigmoid of 1, norm and division of 4 floats: 24 + 8 + 76 bytes.
            elementwise(
                "activate scales, opacities, rotations",
                gaussians,
                108.0,
                6.0,
                device,
            ),
            // torch.cat of 1 and 15 coefficients of three colours: 192 bytes read, 192 written.
            elementwise("concatenate harmonics", gaussians, 384.0, 1.0, device),
            // zeros_like(...) + 0 of three floats.
            elementwise("screen-space means", gaussians, 48.0, 3.0, device),
            binding,
        ]
    }

    /// `preprocessCUDA`. Gaussians lie in no order, so that a warp takes the whole path if one of
    /// its lanes does: 420 instructions, projection, covariance and 16 harmonics.
    fn preprocess(&self) -> Kernel {
        let (gaussians, visible) = (self.gaussians, self.visible.min(self.gaussians));
        // Read up to the covariance: a quarter more than touch a tile.
        let projected = gaussians.min(1.25 * visible);
        let warps = gaussians / WARP;
        let own = Kernel {
            instructions: warps * 420.0,
            fp32: warps * 260.0,
            int: warps * 70.0,
            sfu: warps * 12.0,
            l1_lines: gaussians * 1.5 + visible * 52.0,
            l2_bytes: gaussians * 24.0 + projected * 76.0 + visible * 300.0,
            // 12 position, 8 radius and count; 52 scale, rotation, opacity; 239 harmonics, results.
            dram_bytes: gaussians * 20.0 + projected * 52.0 + visible * 239.0,
            ..Kernel::new("preprocess")
        };
        let counting = self.tested * LONGEST_LANE / WARP * COUNTING;
        self.testing(Kernel {
            instructions: own.instructions + counting,
            int: own.int + counting,
            ..own
        })
    }

    /// The kernel with a test of each pair, if pairs are tested. A lane tests the pairs of its Gaussian.
    fn testing(&self, own: Kernel) -> Kernel {
        if self.tested == 0.0 {
            return own;
        }
        let own = TESTED_GAUSSIAN.times(self.gaussians / WARP, own);
        TEST.times(self.tested * LONGEST_LANE / WARP, own)
    }

    /// `InclusiveSum` of tiles touched; the host reads the number of pairs.
    fn scan(&self) -> Kernel {
        let bytes = self.gaussians * 8.0;
        Kernel {
            instructions: self.gaussians * 20.0 / WARP,
            l1_lines: bytes / LINE,
            l2_bytes: bytes,
            dram_bytes: bytes,
            operations: 2.0,
            waits: true,
            ..Kernel::new("scan of tiles touched")
        }
    }

    /// `duplicateWithKeys`: a lane writes its own run of pairs, so that a warp takes as long as
    /// its longest lane, about four times the mean. 18 instructions a pair. Where pairs are tested, a
    /// warp takes them for each that is tested: some lane keeps its own. Factors and opacity, 16 bytes,
    /// are then read too.
    fn duplicate(&self) -> Kernel {
        let (pairs, gaussians) = (self.pairs, self.gaussians);
        let walked = pairs.max(self.tested) * LONGEST_LANE / WARP;
        let conics = if self.tested > 0.0 { 16.0 } else { 0.0 };
        self.testing(Kernel {
            instructions: walked * 18.0 + gaussians / WARP * 40.0,
            int: walked * 10.0,
            l1_lines: 2.0 * pairs + gaussians * (28.0 + conics) / LINE,
            // Runs start anywhere: a pair of 12 bytes takes two sectors.
            l2_bytes: pairs * 64.0 + gaussians * (28.0 + conics),
            dram_bytes: pairs * 12.0 + self.visible * (24.0 + conics),
            ..Kernel::new("duplicate with keys")
        })
    }

    /// `cub::DeviceRadixSort::SortPairs` of a key of 8 bytes and an index of 4: a histogram, then
    /// a pass of 24 bytes a pair for each 8 bits of depth and tile. On an A100 this traffic is
    /// moved at 81 to 83 % of the peak (caizefan34/3dgs-renderer-benchmark, CUB sort profile).
    fn sort(&self) -> Vec<Kernel> {
        let pairs = self.pairs;
        let passes = ((DEPTH_BITS + self.tiles().max(2.0).log2().ceil()) / DIGIT_BITS).ceil();
        let histogram = Kernel {
            instructions: pairs * 40.0 / WARP,
            l1_lines: pairs * 8.0 / LINE + pairs * passes / WARP,
            l2_bytes: pairs * 8.0,
            dram_bytes: pairs * 8.0,
            operations: 2.0,
            ..Kernel::new("sort: histogram")
        };
        let pass = Kernel {
            instructions: pairs * 80.0 / WARP,
            int: pairs * 45.0 / WARP,
            l1_lines: pairs * 48.0 / LINE + pairs * 12.0 / WARP,
            // Scattered writes fill their sectors in part.
            l2_bytes: pairs * 36.0,
            dram_bytes: pairs * 24.0,
            ..Kernel::new("sort: pass")
        };
        let mut all = vec![histogram];
        all.extend(vec![pass; passes as usize]);
        all
    }

    /// `identifyTileRanges`: reads each key and its neighbour; ranges are zeroed before.
    fn ranges(&self) -> Kernel {
        Kernel {
            instructions: self.pairs * 15.0 / WARP,
            l1_lines: self.pairs * 16.0 / LINE,
            l2_bytes: self.pairs * 16.0,
            dram_bytes: self.pairs * 8.0,
            operations: 2.0,
            ..Kernel::new("tile ranges")
        }
    }

    /// `renderCUDA`: 30 instructions an entry and warp (loop 5, loads of shared memory 2,
    /// quadratic form 9, tests 4, exponential 9, product 1), 24 more where a lane blends.
    #[must_use]
    pub fn render(&self) -> Kernel {
        let (pairs, pixels) = (self.pairs, self.width * self.height);
        let entries = pairs * BLOCK_WARPS * self.walked;
        let mean = pairs / self.tiles().max(1.0);
        // A block loads 256 entries at a time, indices and then what they point at.
        let loads = pairs * self.walked / 256.0 * BLOCK_WARPS;
        Kernel {
            instructions: entries * (30.0 + 24.0 * self.blending),
            fp32: entries * (17.0 + 8.0 * self.blending),
            int: entries * (6.0 + 6.0 * self.blending),
            sfu: entries,
            l1_lines: entries * (2.0 + 4.0 * self.blending) + pairs * 2.1,
            // 100 bytes an entry that is loaded: some more than are walked.
            l2_bytes: pairs * self.walked.sqrt() * 100.0 + pixels * 20.0,
            dram_bytes: self.visible * 144.0 + pairs * 4.0 + pixels * 20.0,
            chained_l2: loads,
            chained_dram: loads,
            serial_clocks: mean * self.longest * self.walked * ENTRY_CLOCKS,
            ..Kernel::new("render")
        }
    }
}

impl Program for Splatting {
    const COUNTS: &'static [Count<Self>] = counts![
        gaussians Count "Gaussians of the model",
        visible Count "Gaussians that touch a tile",
        pairs Count "pairs of a Gaussian and a tile",
        width Fixed "width in pixels",
        height Fixed "height in pixels",
        walked Share "pairs and warps walked before a warp's pixels are opaque",
        blending Share "of those, where a lane blends",
        longest Count "entries of the longest tile over the mean",
    ];

    fn frame(&self, device: &Device) -> Frame {
        let mut kernels = if self.host == Host::Viewer {
            vec![]
        } else {
            self.python(device)
        };
        kernels.extend(self.preparation());
        kernels.push(self.render());
        let launch = match self.host {
            Host::Viewer => Launch::Native,
            Host::Rasterizer | Host::Render => Launch::Framework,
        };
        Frame { launch, kernels }
    }
}
