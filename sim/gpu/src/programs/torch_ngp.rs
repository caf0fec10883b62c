//! torch-ngp (ashawkey) with a hash grid: eager PyTorch in half precision, own kernels for
//! marching, encoding and compositing. All slots are evaluated, filled or not.
//!
//! Source: `nerf/renderer.py` (`run_cuda`), `nerf/network.py` (`forward`), `gridencoder/grid.py`,
//! `raymarching/src/raymarching.cu`. A round is about 40 operations and 2.6 KB a slot.

use super::hash_grid::{Lanes, encode};
use super::rounds::{alive, left, march, shares};
use super::{Count, Program, counts};
use crate::frame::Launch;
use crate::kernel::WARP;
use crate::operations::{copied, elementwise, half_layer, heavier, select};
use crate::{Device, Frame, Kernel};

/// Counts of a frame of torch-ngp.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct TorchNgp {
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
    /// Parameters of the grid, cast to half precision in every call.
    pub parameters: f64,
}

/// First operation of a frame: rays, their intersections with the box, outputs.
fn begin(rays: f64, device: &Device) -> Kernel {
    elementwise(
        "rays, near_far_from_aabb, outputs",
        rays,
        150.0,
        25.0,
        device,
    )
}

/// A frame of the framework: its rounds, `end`, and the copy of colour and depth, in single
/// precision, to the host.
pub(super) fn in_rounds(
    rays: f64,
    rounds: f64,
    device: &Device,
    end: impl IntoIterator<Item = Kernel>,
    round: impl FnMut(f64) -> Vec<Kernel>,
) -> Frame {
    let mut kernels = vec![begin(rays, device)];
    kernels.extend(shares(rounds).into_iter().flat_map(round));
    kernels.extend(end);
    kernels.push(copied("preds.detach().cpu()", rays * 16.0, 4.0));
    Frame {
        launch: Launch::Framework,
        kernels,
    }
}

/// First operations of a round: slots are zeroed, then filled by marching.
pub(super) fn marched(slots: f64, looks: f64, device: &Device) -> [Kernel; 2] {
    [
        elementwise("zero xyzs, dirs, deltas", slots, 64.0, 5.0, device),
        march(looks),
    ]
}

/// Last operations of a round: compositing, and selection of the rays that go on.
pub(super) fn composited(rays: f64, share: f64, slots: f64, device: &Device) -> [Kernel; 2] {
    [
        heavier(
            40.0,
            elementwise("composite_rays", slots, 60.0, 1.0, device),
        ),
        select(
            "rays_alive",
            alive(rays, share),
            left(rays, share),
            4.0,
            device,
        ),
    ]
}

/// A layer in half precision, and its ReLU, which reads and writes as a tensor of its own.
pub(super) fn activated(rows: f64, inputs: f64, outputs: f64, device: &Device) -> [Kernel; 2] {
    [
        half_layer("nn.Linear", rows, (inputs, outputs), device),
        elementwise("ReLU", rows, 4.0 * outputs, 1.0, device),
    ]
}

impl TorchNgp {
    fn round(&self, share: f64, device: &Device) -> Vec<Kernel> {
        let slots = self.slots * share;
        let lanes = Lanes {
            lines: self.lines,
            sectors: self.sectors,
        };
        // grid.py casts the whole table to half precision in every call.
        let cast = Kernel {
            instructions: self.parameters * 4.0 / WARP,
            l2_bytes: self.parameters * 6.0,
            dram_bytes: self.parameters * 6.0,
            ..Kernel::new("cast the table")
        };
        let mut all = vec![];
        all.extend(marched(slots, self.looks * share, device));
        all.extend([
            elementwise("normalise positions", slots, 48.0, 3.0, device),
            cast,
            encode(slots, lanes, device),
            elementwise("permute levels", slots, 128.0, 1.0, device),
        ]);
        all.extend(activated(slots, 32.0, 64.0, device));
        all.extend([
            half_layer("nn.Linear", slots, (64.0, 16.0), device),
            elementwise("trunc_exp", slots, 20.0, 3.0, device),
            elementwise("harmonics of directions", slots, 172.0, 4.0, device),
            elementwise("concatenate", slots, 124.0, 1.0, device),
        ]);
        all.extend(activated(slots, 31.0, 64.0, device));
        all.extend(activated(slots, 64.0, 64.0, device));
        all.extend([
            half_layer("nn.Linear", slots, (64.0, 3.0), device),
            elementwise("sigmoid, scale", slots, 26.0, 3.0, device),
        ]);
        all.extend(composited(self.rays, share, slots, device));
        all
    }
}

impl Program for TorchNgp {
    const COUNTS: &'static [Count<Self>] = counts![
        rays Fixed "rays of the picture",
        slots Count "places for samples in all rounds, all of which are evaluated",
        looks Count "cells of the occupancy grid that rays look at",
        rounds Count "rounds of marching and compaction",
        lines Count "lines of 128 bytes of a request of 32 lanes to the grid",
        sectors Count "sectors of 32 bytes of such a request",
        parameters Fixed "parameters of the grid",
    ];

    fn frame(&self, device: &Device) -> Frame {
        let background = elementwise("background, depth", self.rays, 100.0, 8.0, device);
        in_rounds(self.rays, self.rounds, device, [background], |share| {
            self.round(share, device)
        })
    }
}
