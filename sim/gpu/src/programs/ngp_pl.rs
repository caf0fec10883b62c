//! ngp_pl (kwea123): rays are compacted in eager PyTorch, encoding and layers are fused kernels of
//! tiny-cuda-nn in half precision.
//!
//! Source: `models/rendering.py` (`__render_rays_test`), `models/networks.py` (`NGP.forward`),
//! `models/csrc/raymarching.cu`. A round is about 58 operations and 6 waits.

use super::hash_grid::{Lanes, encode};
use super::rounds::{alive, left, march, shares};
use super::{Count, Program, counts};
use crate::frame::Launch;
use crate::operations::{elementwise, heavier, select, waited};
use crate::{Device, Frame, Kernel};

/// Counts of a frame of ngp_pl.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct NgpPl {
    /// Rays of the picture.
    pub rays: f64,
    /// Places for samples in all rounds, filled or not.
    pub slots: f64,
    /// Filled ones, which are evaluated.
    pub effective: f64,
    /// Cells of the occupancy grid that rays look at.
    pub looks: f64,
    /// Rounds.
    pub rounds: f64,
    /// Lines of a request of 32 lanes to the grid.
    pub lines: f64,
    /// Sectors of such a request.
    pub sectors: f64,
}

impl NgpPl {
    fn round(&self, share: f64, device: &Device) -> Vec<Kernel> {
        let (slots, effective) = (self.slots * share, self.effective * share);
        let mut all = self.marching(share, slots, effective, device);
        all.extend(self.model(effective, device));
        all.extend([
            elementwise("cast colours", effective, 18.0, 1.0, device),
            // sigmas[valid_mask] = ..., rgbs[valid_mask] = ...
            select("scatter densities", slots, effective, 4.0, device),
            select("scatter colours", slots, effective, 12.0, device),
            heavier(
                40.0,
                elementwise("composite_test_fw", slots, 60.0, 1.0, device),
            ),
            select(
                "alive_indices",
                alive(self.rays, share),
                left(self.rays, share),
                8.0,
                device,
            ),
        ]);
        all
    }

    /// Up to the model: march, mask of filled slots, rows that are filled.
    fn marching(&self, share: f64, slots: f64, effective: f64, device: &Device) -> Vec<Kernel> {
        vec![
            elementwise("allocate and zero samples", slots, 36.0, 7.0, device),
            march(self.looks * share),
            elementwise("N_eff_samples", slots / 4.0, 4.0, 2.0, device),
            // ~torch.all(dirs == 0, dim=1); its sum is read by the host.
            waited(elementwise("valid_mask", slots, 15.0, 3.0, device)),
            elementwise("zero outputs", slots, 16.0, 2.0, device),
            select("xyzs[valid_mask]", slots, effective, 12.0, device),
            select("dirs[valid_mask]", slots, effective, 12.0, device),
        ]
    }

    /// `NGP.forward`: about 1.0 KB a sample with its encoding.
    fn model(&self, effective: f64, device: &Device) -> Vec<Kernel> {
        let lanes = Lanes {
            lines: self.lines,
            sectors: self.sectors,
        };
        let fused = |name, macs: f64| Kernel {
            tensor_flops: effective * 2.0 * macs,
            l2_bytes: effective * 192.0,
            dram_bytes: effective * 96.0,
            operations: 2.0,
            ..Kernel::new(name)
        };
        vec![
            elementwise("normalise positions", effective, 48.0, 3.0, device),
            encode(effective, lanes, device),
            fused("xyz_encoder layers", 32.0 * 64.0 + 64.0 * 16.0),
            elementwise("TruncExp, casts", effective, 40.0, 4.0, device),
            elementwise(
                "directions: norm, scale, harmonics, cast",
                effective,
                150.0,
                8.0,
                device,
            ),
            elementwise("concatenate", effective, 128.0, 1.0, device),
            fused("rgb_net layers", 32.0 * 64.0 + 64.0 * 64.0 + 64.0 * 16.0),
        ]
    }
}

impl Program for NgpPl {
    const COUNTS: &'static [Count<Self>] = counts![
        rays Fixed "rays of the picture",
        slots Count "places for samples in all rounds, filled or not",
        effective Count "filled places, which are evaluated",
        looks Count "cells of the occupancy grid that rays look at",
        rounds Count "rounds of marching and compaction",
        lines Count "lines of 128 bytes of a request of 32 lanes to the grid",
        sectors Count "sectors of 32 bytes of such a request",
    ];

    fn frame(&self, device: &Device) -> Frame {
        let mut kernels = vec![elementwise(
            "ray_aabb_intersect",
            self.rays,
            60.0,
            8.0,
            device,
        )];
        for share in shares(self.rounds) {
            kernels.extend(self.round(share, device));
        }
        kernels.push(elementwise("background", self.rays, 60.0, 5.0, device));
        Frame {
            launch: Launch::Framework,
            kernels,
        }
    }
}
