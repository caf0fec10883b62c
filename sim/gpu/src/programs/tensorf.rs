//! torch-ngp with TensoRF: planes and lines through `grid_sample`, channel-major in single
//! precision. Densities and colours of all slots are evaluated.
//!
//! Source: torch-ngp `tensoRF/network.py` (`forward`, `get_sigma_feat`, `get_color_feat`); 16
//! components of density and 48 of colour. About 13.3 KB a slot.

use super::torch_ngp::{activated, composited, in_rounds, marched};
use super::{Count, Program, counts};
use crate::kernel::{SECTOR, WARP};
use crate::operations::{elementwise, half_layer};
use crate::{Device, Frame, Kernel};

/// Components of density and of colour.
const DENSITY: f64 = 16.0;
const COLOUR: f64 = 48.0;
/// Sectors that hit L2 for one that comes from memory: neighbouring samples share corners.
const REUSE: f64 = 12.0;

/// Counts of a frame of TensoRF in torch-ngp.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TorchTensorf {
    /// Rays of the picture.
    pub rays: f64,
    /// Places for samples in all rounds, filled or not; all are evaluated.
    pub slots: f64,
    /// Cells of the occupancy grid that rays look at.
    pub looks: f64,
    /// Rounds.
    pub rounds: f64,
    /// Lines of a request of 32 lanes to a channel-major plane.
    pub lines: f64,
    /// Sectors of such a request.
    pub sectors: f64,
}

impl TorchTensorf {
    /// `F.grid_sample`: 80 instructions for the corners, 9 for each channel and corner.
    fn sampled(&self, name: &'static str, slots: f64, channels: f64, corners: f64) -> Kernel {
        let requests = slots * channels * corners / WARP;
        let bytes = requests * self.sectors * SECTOR;
        Kernel {
            instructions: slots * (80.0 + channels * corners * 9.0) / WARP,
            fp32: slots * (50.0 + channels * corners * 2.0) / WARP,
            l1_lines: requests * self.lines,
            l2_bytes: bytes,
            dram_bytes: slots * (8.0 + 4.0 * channels) + bytes / REUSE,
            ..Kernel::new(name)
        }
    }

    /// Three planes and lines of that many components, multiplied and, for densities, summed.
    fn features(&self, slots: f64, components: f64, device: &Device) -> Vec<Kernel> {
        let mut all = vec![elementwise(
            "coordinates of planes",
            slots,
            180.0,
            9.0,
            device,
        )];
        for _ in 0..3 {
            all.push(self.sampled("grid_sample: plane", slots, components, 4.0));
            all.push(self.sampled("grid_sample: line", slots, components, 2.0));
            if components == DENSITY {
                let bytes = components * 16.0 + 12.0;
                all.push(elementwise("multiply, sum", slots, bytes, 3.0, device));
            }
        }
        all
    }

    fn round(&self, share: f64, device: &Device) -> Vec<Kernel> {
        let slots = self.slots * share;
        let mut all = vec![];
        all.extend(marched(slots, self.looks * share, device));
        all.push(elementwise("normalise positions", slots, 72.0, 4.0, device));
        all.extend(self.features(slots, DENSITY, device));
        all.extend(self.features(slots, COLOUR, device));
        all.extend([
            // 3 * 48 features of planes and of lines: read, written.
            elementwise("concatenate features", slots, 2304.0, 2.0, device),
            elementwise("multiply features", slots, 1728.0, 1.0, device),
            elementwise("transpose, cast", slots, 864.0, 1.0, device),
            half_layer("basis_mat", slots, (144.0, 27.0), device),
            elementwise(
                "frequencies of features and directions",
                slots,
                1362.0,
                5.0,
                device,
            ),
        ]);
        all.extend(activated(slots, 150.0, 128.0, device));
        all.extend(activated(slots, 128.0, 128.0, device));
        all.extend([
            half_layer("nn.Linear", slots, (128.0, 3.0), device),
            elementwise("sigmoid, exp", slots, 40.0, 5.0, device),
        ]);
        all.extend(composited(self.rays, share, slots, device));
        all
    }
}

impl Program for TorchTensorf {
    const COUNTS: &'static [Count<Self>] = counts![
        rays Fixed "rays of the picture",
        slots Count "places for samples in all rounds, all of which are evaluated",
        looks Count "cells of the occupancy grid that rays look at",
        rounds Count "rounds of marching and compaction",
        lines Count "lines of 128 bytes of a request of 32 lanes to a plane",
        sectors Count "sectors of 32 bytes of such a request",
    ];

    fn frame(&self, device: &Device) -> Frame {
        in_rounds(self.rays, self.rounds, device, [], |share| {
            self.round(share, device)
        })
    }
}
