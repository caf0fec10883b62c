//! A grid of hash tables in element-wise tensors, without a kernel of its own.
//!
//! Source: HashNeRF-pytorch `hash_encoding.py` (`HashEmbedder.forward`, `trilinear_interp`) and
//! `utils.py` (`get_voxel_vertices`, `hash`): about 61 operations a level with 64-bit indices of
//! eight corners, 2.6 KB a sample and level.

use super::hash_grid::{ENTRIES, LEVELS};
use super::{Count, Program, counts};
use crate::frame::Launch;
use crate::kernel::{SECTOR, WARP};
use crate::operations::{elementwise, layer, waited};
use crate::{Device, Frame, Kernel};

/// Samples of a chunk.
const CHUNK: f64 = 524_288.0;
/// Bytes of an entry: two single-precision features.
const ENTRY_BYTES: f64 = 8.0;

/// Counts of a frame of an eager hash grid.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EagerHash {
    /// Samples that are evaluated.
    pub samples: f64,
    /// Share of the samples whose layers run on the GPU: 0 where an NPU evaluates them.
    pub layers: f64,
}

impl EagerHash {
    /// One level of a chunk.
    fn level(samples: f64, device: &Device) -> [Kernel; 5] {
        let missed = (1.0 - device.l2_bytes * 0.8 / (ENTRIES * ENTRY_BYTES)).max(0.0);
        let gather = Kernel {
            instructions: samples * 8.0 * 15.0 / WARP,
            l1_lines: samples * 8.0 * 0.7,
            l2_bytes: samples * 8.0 * 48.0,
            // Index and features; half of the corners lie in a sector of their own.
            dram_bytes: samples * 8.0 * (16.0 + SECTOR * 0.5 * missed),
            ..Kernel::new("nn.Embedding")
        };
        [
            // Clamp and tests 60 bytes, cell 48, weights and casts 42; the host reads a test.
            waited(elementwise(
                "get_voxel_vertices: cell",
                samples,
                150.0,
                10.0,
                device,
            )),
            elementwise("get_voxel_vertices: corners", samples, 108.0, 2.0, device),
            // Three products (96 + 64 + 64 bytes) and exclusive ors (3 * 64), and the mask 128.
            elementwise("hash", samples, 3.0 * (224.0 + 192.0) + 128.0, 8.0, device),
            gather,
            // Weights 36; seven interpolations of pairs.
            elementwise("trilinear_interp", samples, 36.0 + 7.0 * 96.0, 40.0, device),
        ]
    }
}

impl Program for EagerHash {
    const COUNTS: &'static [Count<Self>] = counts![
        samples Count "samples that are evaluated",
        layers Share "samples whose layers run on the GPU",
    ];

    fn frame(&self, device: &Device) -> Frame {
        let chunks = (self.samples / CHUNK).ceil();
        let samples = self.samples / chunks.max(1.0);
        let mut kernels = vec![];
        for _ in 0..chunks as usize {
            for _ in 0..LEVELS as usize {
                kernels.extend(Self::level(samples, device));
            }
            kernels.push(elementwise(
                "concatenate levels",
                samples,
                256.0,
                1.0,
                device,
            ));
            let here = samples * self.layers;
            if here > 0.0 {
                for shape in [
                    (32.0, 64.0),
                    (64.0, 16.0),
                    (31.0, 64.0),
                    (64.0, 64.0),
                    (64.0, 3.0),
                ] {
                    kernels.push(layer("nn.Linear", here, shape, device));
                    kernels.push(elementwise("ReLU", here, 8.0 * shape.1, 1.0, device));
                }
            }
        }
        kernels.push(elementwise(
            "rays, masks, composite",
            self.samples,
            300.0,
            60.0,
            device,
        ));
        Frame {
            launch: Launch::Framework,
            kernels,
        }
    }
}
