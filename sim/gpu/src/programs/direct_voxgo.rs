//! DirectVoxGO (sunset1995), version 2: eager PyTorch in chunks of rays, own kernels for sampling
//! and weights.
//!
//! Source: `lib/dvgo.py` (`forward`, `sample_ray`), `lib/grid.py` (`DenseGrid`, `MaskGrid`),
//! `lib/cuda/render_utils_kernel.cu`, and `run.py`, which renders 8192 rays at a time: 79 chunks
//! of an 800 x 800 picture, each of about 137 operations and 17 waits.

use super::{Count, Program, counts};
use crate::frame::Launch;
use crate::kernel::{LINE, SECTOR, WARP};
use crate::operations::{copied, elementwise, heavier, layer, select, waited};
use crate::{Device, Frame, Kernel};

/// Rays of a chunk.
const CHUNK: f64 = 8192.0;
/// Sectors that hit L2 for one that comes from memory: neighbouring samples share corners.
const REUSE: f64 = 6.0;
/// Threads that walk neighbouring rays read apart: instructions of a warp over those of a lane.
const APART: f64 = 3.0;

/// Counts of a frame of DirectVoxGO.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DirectVoxGo {
    /// Rays of the picture.
    pub rays: f64,
    /// Regular samples in the box.
    pub in_box: f64,
    /// Of these, in the mask of known free space.
    pub in_mask: f64,
    /// Of these, with an opacity above the threshold.
    pub by_alpha: f64,
    /// Of these, with a weight above the threshold: colours are evaluated.
    pub by_weight: f64,
    /// Voxels of the grid.
    pub voxels: f64,
    /// Channels of the colour grid.
    pub channels: f64,
    /// Lines of a request of 32 lanes to one corner of a channel-major grid.
    pub lines: f64,
    /// Sectors of such a request.
    pub sectors: f64,
}

/// Samples of one chunk that survive each test.
#[derive(Clone, Copy)]
struct Chunk {
    rays: f64,
    in_box: f64,
    in_mask: f64,
    by_alpha: f64,
    by_weight: f64,
}

impl DirectVoxGo {
    fn chunk(&self, part: Chunk, device: &Device) -> Vec<Kernel> {
        let mut all = self.points(part, device);
        all.extend(self.densities(part, device));
        all.extend(self.weights(part, device));
        all.extend(self.colours(part, device));
        all
    }

    /// `sample_ray` and the mask: 187 bytes a sample in the box.
    fn points(&self, part: Chunk, device: &Device) -> Vec<Kernel> {
        let (samples, masked) = (part.in_box, part.in_mask);
        let mask = Kernel {
            instructions: samples / WARP * 35.0,
            fp32: samples / WARP * 8.0,
            l1_lines: samples * (13.0 / LINE + self.lines / WARP),
            l2_bytes: samples * (14.0 + SECTOR * self.sectors / WARP),
            dram_bytes: samples * 14.0 + self.voxels.min(samples * 4.0),
            operations: 2.0,
            ..Kernel::new("maskcache_lookup")
        };
        let ids = elementwise("ray and step ids, points", samples, 77.0, 6.0, device);
        vec![
            elementwise(
                "infer_t_minmax, infer_n_samples",
                part.rays,
                120.0,
                12.0,
                device,
            ),
            waited(elementwise("N_steps.sum()", part.rays, 8.0, 1.0, device)),
            heavier(30.0, ids),
            select("in the box: points", samples, samples, 12.0, device),
            select("in the box: rays", samples, samples, 8.0, device),
            select("in the box: steps", samples, samples, 8.0, device),
            mask,
            select("in the mask: points", samples, masked, 12.0, device),
            select("in the mask: rays", samples, masked, 8.0, device),
            select("in the mask: steps", samples, masked, 8.0, device),
        ]
    }

    /// `F.grid_sample` of a channel-major grid in single precision.
    fn sampled(&self, name: &'static str, samples: f64, channels: f64, cost: [f64; 3]) -> Kernel {
        let [instructions, fp32, other_bytes] = cost;
        let corners = channels * 8.0;
        Kernel {
            instructions: samples / WARP * instructions,
            fp32: samples / WARP * fp32,
            l1_lines: samples * corners * self.lines / WARP,
            l2_bytes: samples * corners * self.sectors,
            dram_bytes: samples * (other_bytes + corners * self.sectors / REUSE),
            ..Kernel::new(name)
        }
    }

    /// Densities in the mask, and their opacities: 104 + 163 bytes a sample.
    fn densities(&self, part: Chunk, device: &Device) -> Vec<Kernel> {
        let samples = part.in_mask;
        let raw2alpha = elementwise("raw2alpha", samples, 17.0, 3.0, device);
        let mut all = vec![
            elementwise("density: normalise", samples, 120.0, 5.0, device),
            self.sampled("density: grid_sample", samples, 1.0, [150.0, 60.0, 16.0]),
            heavier(50.0, raw2alpha),
        ];
        for row in [12.0, 8.0, 8.0, 4.0, 4.0] {
            all.push(select("by alpha", samples, part.by_alpha, row, device));
        }
        all
    }

    /// Weights of samples above the alpha threshold: 152 + 51 bytes a sample.
    fn weights(&self, part: Chunk, device: &Device) -> Vec<Kernel> {
        let samples = part.by_alpha;
        let walk = Kernel {
            instructions: samples * 25.0 / WARP * APART,
            l1_lines: samples * APART,
            l2_bytes: samples * APART * SECTOR,
            dram_bytes: samples * 16.0,
            // A thread a ray; the longest has about four times the mean, 300 clocks a step.
            serial_clocks: 4.0 * samples / part.rays.max(1.0) * 300.0,
            ..Kernel::new("alpha2weight")
        };
        let mut all = vec![
            elementwise("Alphas2Weights: zero, segments", samples, 24.0, 6.0, device),
            walk,
            elementwise("weights > threshold", samples, 5.0, 1.0, device),
        ];
        for row in [4.0, 4.0, 12.0, 8.0, 8.0] {
            all.push(select("by weight", samples, part.by_weight, row, device));
        }
        all
    }

    /// Features, colours and their sum: 5.1 KB a sample and 21,760 multiplications.
    fn colours(&self, part: Chunk, device: &Device) -> Vec<Kernel> {
        let samples = part.by_weight;
        let corners = self.channels * 8.0;
        let cost = [110.0 + corners * 9.0, 60.0 + corners * 2.0, 60.0];
        let sum = elementwise("segment_coo, depth", samples, 60.0, 8.0, device);
        let mut all = vec![
            elementwise("k0: normalise", samples, 108.0, 5.0, device),
            self.sampled("k0: grid_sample", samples, self.channels, cost),
            elementwise("k0: transpose", samples, 8.0 * self.channels, 1.0, device),
            elementwise("view directions", samples, 224.0, 8.0, device),
            elementwise("concatenate", samples, 312.0, 1.0, device),
        ];
        for shape in [(39.0, 128.0), (128.0, 128.0)] {
            all.push(layer("rgbnet: nn.Linear", samples, shape, device));
            all.push(elementwise("rgbnet: ReLU", samples, 1024.0, 1.0, device));
        }
        all.extend([
            layer("rgbnet: nn.Linear", samples, (128.0, 3.0), device),
            elementwise("sigmoid, weigh", samples, 52.0, 3.0, device),
            heavier(30.0, sum),
        ]);
        all
    }
}

impl Program for DirectVoxGo {
    const COUNTS: &'static [Count<Self>] = counts![
        rays Fixed "rays of the picture",
        in_box Count "regular samples in the box",
        in_mask Count "of these, in the mask of known free space",
        by_alpha Count "of these, above the threshold of opacity",
        by_weight Count "of these, above the threshold of weight",
        voxels Fixed "voxels of the grid",
        channels Fixed "channels of the colour grid",
        lines Count "lines of 128 bytes of a request of 32 lanes to a corner",
        sectors Count "sectors of 32 bytes of such a request",
    ];

    fn frame(&self, device: &Device) -> Frame {
        let chunks = (self.rays / CHUNK).ceil();
        let part = |all: f64| all / chunks.max(1.0);
        let one = Chunk {
            rays: part(self.rays),
            in_box: part(self.in_box),
            in_mask: part(self.in_mask),
            by_alpha: part(self.by_alpha),
            by_weight: part(self.by_weight),
        };
        let mut kernels = vec![];
        for _ in 0..chunks as usize {
            kernels.extend(self.chunk(one, device));
        }
        // Colour, depth and transmittance in single precision.
        kernels.push(copied("render_result to the host", self.rays * 20.0, 6.0));
        Frame {
            launch: Launch::Framework,
            kernels,
        }
    }
}
