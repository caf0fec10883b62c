//! Rounds of ray marchers that compact their rays: march, evaluate, composite, until none is left.

use crate::Kernel;
use crate::kernel::{SECTOR, WARP};

/// Steps of a warp over the mean of its rays: it marches as long as its longest ray.
const LONGEST_RAY: f64 = 2.0;
/// Instructions of a look at the occupancy grid: position, Morton code, bit, step to the next cell
/// (`kernel_march_rays` of torch-ngp, `raymarching_test_kernel` of ngp_pl).
const LOOK_INSTRUCTIONS: f64 = 95.0;
/// Clocks of a look that wait for each other, other than for L2.
const LOOK_CLOCKS: f64 = 180.0;
/// Looks whose bits do not lie in L1: the grid of 128^3 bits is 256 KB, rays are coherent.
const LOOK_L2: f64 = 0.5;
/// Share of an SM's warps that march at the same time, for registers.
const RESIDENT: f64 = 0.6;

/// Share of the slots in each round. The first round takes all rays; the next ones shrink as rays
/// end, and later ones share what is left in equal parts, since rays get more samples as there
/// are fewer of them.
pub(super) fn shares(rounds: f64) -> Vec<f64> {
    let rounds = rounds.round().max(0.0) as usize;
    let weight = |round: usize| {
        if round < 4 {
            0.55_f64.powi(round as i32)
        } else {
            0.12
        }
    };
    let all: f64 = (0..rounds).map(weight).sum();
    (0..rounds).map(|round| weight(round) / all).collect()
}

/// A thread a ray: each look at a cell waits for the one before.
#[must_use]
pub fn march(looks: f64) -> Kernel {
    let warps = looks / WARP * LONGEST_RAY;
    Kernel {
        instructions: warps * LOOK_INSTRUCTIONS,
        fp32: warps * 45.0,
        int: warps * 30.0,
        sfu: warps,
        l1_lines: warps * 4.0,
        l2_bytes: warps * 3.0 * SECTOR,
        chained_l2: warps * LOOK_L2,
        chained_clocks: warps * LOOK_CLOCKS,
        resident: RESIDENT,
        ..Kernel::new("march")
    }
}

/// Rays at work in a round with that share of the slots: all in the first, fewer as rays end.
pub(super) fn alive(rays: f64, share: f64) -> f64 {
    rays * (4.0 * share).min(1.0)
}

/// Rays that remain after that round.
pub(super) fn left(rays: f64, share: f64) -> f64 {
    rays * share
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_add_up_and_fall() {
        for rounds in [1.0, 3.0, 10.0, 31.0] {
            let all = shares(rounds);
            assert_eq!(all.len() as f64, rounds);
            assert!((all.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(all.windows(2).all(|w| w[0] >= w[1]));
        }
        assert!(shares(0.0).is_empty());
    }
}
