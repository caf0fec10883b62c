//! The occupancy grid of Instant-NGP: cells of the unit cube, and of cubes around it of twice the
//! side each, that may be non-empty.

use glam::DVec3;

/// Cells along an axis of each cube.
pub(super) const CELLS: u32 = 128;
/// Cells in a cube.
pub(super) const VOLUME: usize = (CELLS as usize).pow(3);
/// Optical thickness of one step from which on a cell is occupied, unless the mean of the
/// innermost cube is less.
const THINNEST: f64 = 0.01;

/// Occupied cells, one bit each, cube after cube from the innermost, the unit cube.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub(super) struct Occupancy {
    /// Bits in Morton order.
    bits: Vec<u64>,
    cubes: usize,
}

/// The index of a cell in Morton order: interleaved bits of x, y and z, x lowest.
pub(super) fn morton(cell: [u32; 3]) -> usize {
    let spread = |part: u32| (0..7).fold(0, |sum, bit| sum | (part >> bit & 1) << (3 * bit));
    let [x, y, z] = cell.map(spread);
    (x | y << 1 | z << 2) as usize
}

impl Occupancy {
    /// Builds the grid from the optical thickness of each cell in Morton order, in whole cubes.
    pub(super) fn new(thickness: &[f32]) -> Self {
        let inner = &thickness[..VOLUME.min(thickness.len())];
        let sum: f64 = inner.iter().map(|v| f64::from(v.max(0.0))).sum();
        let least = THINNEST.min(sum / VOLUME as f64);
        let words = thickness.chunks(64);
        let bits = words.map(|cells| {
            let filled = cells.iter().map(|v| u64::from(f64::from(*v) > least));
            filled.enumerate().fold(0, |word, (i, bit)| word | bit << i)
        });
        Self {
            bits: bits.collect(),
            cubes: thickness.len() / VOLUME,
        }
    }

    /// Number of empty cells, and of all cells.
    pub(super) fn void(&self) -> [u64; 2] {
        let cells = (self.cubes * VOLUME) as u64;
        let filled: u64 = self
            .bits
            .iter()
            .map(|word| u64::from(word.count_ones()))
            .sum();
        [cells - filled.min(cells), cells]
    }

    /// Whether the field may be non-empty at a position in the unit cube's frame. The innermost
    /// cube that contains it decides.
    pub(super) fn holds(&self, at: DVec3) -> bool {
        let middle = at - 0.5;
        let reach = middle.abs().max_element();
        let mut cube = 0;
        let mut half = 0.5;
        if !reach.is_finite() {
            return false;
        }
        while reach >= half {
            cube += 1;
            half *= 2.0;
            if cube >= self.cubes {
                return false;
            }
        }
        let cell = (middle / half + 1.0) * f64::from(CELLS / 2);
        let cell = cell.to_array().map(|v| (v as u32).min(CELLS - 1));
        let bit = cube * VOLUME + morton(cell);
        self.bits[bit / 64] >> (bit % 64) & 1 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_in_morton_order() {
        for (cell, place) in [
            ([0, 0, 0], 0),
            ([1, 0, 0], 1),
            ([0, 1, 0], 2),
            ([0, 0, 1], 4),
            ([2, 0, 0], 8),
            ([3, 5, 6], 0b110_101_011),
            ([127, 127, 127], VOLUME - 1),
            ([64, 0, 0], 1 << 18),
            ([0, 0, 64], 1 << 20),
        ] {
            assert_eq!(morton(cell), place, "{cell:?}");
        }
    }

    /// One cell in each of two cubes; the larger says nothing of what lies in
    /// the smaller.
    #[test]
    fn the_innermost_cube_that_holds_a_place_says() {
        let mut thickness = vec![0.0; 2 * VOLUME];
        thickness[morton([0, 64, 127])] = 1.0;
        thickness[VOLUME + morton([10, 64, 64])] = 1.0;
        thickness[VOLUME + morton([64, 64, 64])] = 1.0;
        let grid = Occupancy::new(&thickness);
        let cell = 1.0 / 128.0;
        let at = |x: f64, y: f64, z: f64| grid.holds(DVec3::new(x, y, z));
        assert!(at(0.5 * cell, 0.5 + 0.5 * cell, 1.0 - 0.5 * cell));
        assert!(!at(1.5 * cell, 0.5 + 0.5 * cell, 1.0 - 0.5 * cell));
        // The larger cube reaches from -0.5 to 1.5 in cells of 1/64.
        assert!(at(-0.5 + 21.0 * cell, 0.51, 0.51));
        assert!(!at(-0.5 + 19.9 * cell, 0.51, 0.51));
        assert!(!at(0.501, 0.501, 0.501), "hidden by the smaller cube");
        for outside in [1.6, -0.6, f64::NAN, f64::INFINITY] {
            assert!(!at(outside, 0.5, 0.5), "{outside}");
        }
    }

    /// The limit is the mean where that is thinner than 0.01.
    #[test]
    fn thin_cells_count_by_the_mean() {
        let mut thickness = vec![0.0; VOLUME];
        thickness[..VOLUME / 4].fill(0.004);
        assert!(Occupancy::new(&thickness).holds(DVec3::splat(0.1)));
        thickness[VOLUME / 2..].fill(1.0);
        assert!(!Occupancy::new(&thickness).holds(DVec3::splat(0.1)));
    }
}
