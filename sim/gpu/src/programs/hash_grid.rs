//! The kernel that encodes positions in a grid of hash tables: `kernel_grid` of torch-ngp and of
//! tiny-cuda-nn, a thread a sample and level.

use crate::kernel::{SECTOR, WARP};
use crate::{Device, Kernel};

/// Levels, and entries of a hashed one (Müller et al. 2022: 16 levels, 2^19 entries).
pub(super) const LEVELS: f64 = 16.0;
pub(super) const ENTRIES: f64 = 524_288.0;
/// Bytes of an entry: two half-precision features.
const ENTRY_BYTES: f64 = 4.0;
/// Bytes that are written for a sample: 32 half-precision features.
const OUTPUT_BYTES: f64 = 64.0;
/// Levels with more entries than cells of the grid, which are hashed.
const HASHED_LEVELS: f64 = 11.0;
/// Instructions of a level: 30 for the cell; for each corner a weight 3, the hash 8, the remainder
/// by a size that is a variable 14, load and address 2, accumulate 2.
const LEVEL_INSTRUCTIONS: f64 = 30.0 + 8.0 * 29.0;
/// Part of L2 that a level may fill and stay there.
const KEPT: f64 = 0.8;
/// Part of the sectors of a hashed level that its levels miss together where it does not fit:
/// coarse levels fit still.
const MISSING: f64 = 0.7;

/// How the 32 lanes of a request lie in the grid, mean of all levels.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Lanes {
    /// Lines of 128 bytes of a request for one corner.
    pub lines: f64,
    /// Sectors of 32 bytes of such a request.
    pub sectors: f64,
}

/// Encodes so many samples. Levels run one after the other, so that one lies in L2 at a time.
pub(super) fn encode(samples: f64, lanes: Lanes, device: &Device) -> Kernel {
    let requests = samples * LEVELS * 8.0 / WARP;
    let level = ENTRIES * ENTRY_BYTES;
    // Neighbours along x share a sector seven times in eight.
    let sectors = requests * lanes.sectors / 2.0;
    let missed = (1.0 - device.l2_bytes * KEPT / level).max(0.0);
    let tables = (samples * 8.0 * SECTOR).min(level) * HASHED_LEVELS;
    Kernel {
        instructions: samples * LEVELS * LEVEL_INSTRUCTIONS / WARP,
        fp32: samples * LEVELS * 70.0 / WARP,
        int: samples * LEVELS * 150.0 / WARP,
        l1_lines: requests * lanes.lines,
        l2_bytes: sectors * SECTOR,
        dram_bytes: samples * (24.0 + OUTPUT_BYTES) + tables + missed * MISSING * sectors * SECTOR,
        ..Kernel::new("hash encoding")
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use super::*;

    #[test]
    fn a_level_that_fits_in_l2_misses_nothing() {
        let lanes = Lanes {
            lines: 8.0,
            sectors: 9.5,
        };
        let of = |name| encode(1e6, lanes, &Device::builtin(name).unwrap()).dram_bytes;
        let tables = 11.0 * 524_288.0 * 4.0;
        assert_eq!(of("a6000"), 1e6 * 88.0 + tables);
        assert!(of("xavier-maxn") > 2.0 * of("a6000"));
    }
}
