//! instant-ngp (NVlabs): compaction, encoding and layers in C++, without a framework.
//!
//! Source: `src/testbed_nerf.cu` (`NerfTracer::trace`) and tiny-cuda-nn's fused layers in half
//! precision. All slots are evaluated; the host waits once a round for the number of rays alive.

use super::hash_grid::{Lanes, encode};
use super::rounds::march;
use super::{Count, Program, counts};
use crate::frame::Launch;
use crate::kernel::WARP;
use crate::{Device, Frame, Kernel};

/// Multiply-adds of both networks: 32-64-16 and 32-64-64-16.
const MACS: f64 = 32.0 * 64.0 + 64.0 * 16.0 + 32.0 * 64.0 + 64.0 * 64.0 + 64.0 * 16.0;

/// Counts of a frame of instant-ngp.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct InstantNgp {
    /// Rays of the picture.
    pub rays: f64,
    /// Places for samples in all rounds, filled or not; all are evaluated.
    pub slots: f64,
    /// Cells of the occupancy grid that rays look at.
    pub looks: f64,
    /// Rounds.
    pub rounds: f64,
    /// Lines of a request of 32 lanes to the grid.
    pub lines: f64,
    /// Sectors of such a request.
    pub sectors: f64,
}

impl InstantNgp {
    fn round(&self, device: &Device) -> [Kernel; 5] {
        let part = |all: f64| all / self.rounds;
        let (rays, slots) = (part(self.rays), part(self.slots));
        let lanes = Lanes {
            lines: self.lines,
            sectors: self.sectors,
        };
        [
            Kernel {
                instructions: rays * 40.0 / WARP,
                // Payload, colour and depth, read and written.
                dram_bytes: rays * 140.0,
                operations: 2.0,
                waits: true,
                ..Kernel::new("compact_kernel_nerf")
            },
            march(part(self.looks)),
            encode(slots, lanes, device),
            Kernel {
                tensor_flops: slots * 2.0 * MACS,
                l2_bytes: slots * 300.0,
                dram_bytes: slots * 220.0,
                operations: 3.0,
                ..Kernel::new("fused layers")
            },
            Kernel {
                instructions: slots * 60.0 / WARP,
                dram_bytes: slots * 60.0,
                ..Kernel::new("composite_kernel_nerf")
            },
        ]
    }
}

impl Program for InstantNgp {
    const COUNTS: &'static [Count<Self>] = counts![
        rays Fixed "rays of the picture",
        slots Count "places for samples in all rounds, all of which are evaluated",
        looks Count "cells of the occupancy grid that rays look at",
        rounds Count "rounds of marching and compaction",
        lines Count "lines of 128 bytes of a request of 32 lanes to the grid",
        sectors Count "sectors of 32 bytes of such a request",
    ];

    fn frame(&self, device: &Device) -> Frame {
        let mut kernels = vec![Kernel {
            instructions: self.rays * 120.0 / WARP,
            dram_bytes: self.rays * 90.0,
            operations: 3.0,
            ..Kernel::new("init_rays_with_payload_kernel_nerf")
        }];
        for _ in 0..self.rounds.round() as usize {
            kernels.extend(self.round(device));
        }
        Frame {
            launch: Launch::Native,
            kernels,
        }
    }
}
