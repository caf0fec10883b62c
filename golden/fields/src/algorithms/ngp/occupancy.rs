//! The occupancy grid of Instant-NGP: cells of the unit cube, and of cubes around it of twice the
//! side each, that may be non-empty.

use glam::DVec3;

/// Cells along an axis of each cube.
pub(super) const CELLS: u32 = 128;
/// Cells in a cube.
pub(super) const VOLUME: usize = (CELLS as usize).pow(3);
/// Bits of a block of 16 x 16 x 16 cells, which are consecutive.
const BLOCK: usize = 16 * 16 * 16;
/// A block's distance from its faces within which positions are looked up one by one, in cells.
const MARGIN: f64 = 1e-6;
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

    /// Whether the field may be non-empty at a position in the unit cube's frame.
    pub(super) fn holds(&self, at: DVec3) -> bool {
        self.cell(at).is_some_and(|cell| cell.is_filled(self))
    }

    /// The length along a unit direction from a position on which the field is empty, or `None`
    /// where it may be non-empty. It ends before the block of empty cells does.
    pub(super) fn empty_for(&self, at: DVec3, direction: DVec3) -> Option<f64> {
        let Some(cell) = self.cell(at) else {
            return Some(0.0);
        };
        if cell.is_filled(self) {
            return None;
        }
        let word = self.bits[cell.bit() / 64];
        let edge = match word {
            0 if self.is_empty(cell.bit() / BLOCK * BLOCK) => 16,
            0 => 4,
            _ => 1,
        };
        Some(cell.reach(edge, direction))
    }

    /// Whether a block of 16 x 16 x 16 cells is empty, from its first bit.
    fn is_empty(&self, first: usize) -> bool {
        self.bits[first / 64..][..BLOCK / 64]
            .iter()
            .all(|word| *word == 0)
    }

    /// The cell of a position: of the innermost cube that contains it.
    fn cell(&self, at: DVec3) -> Option<Cell> {
        let middle = at - 0.5;
        let reach = middle.abs().max_element();
        let mut cube = 0;
        let mut half = 0.5;
        if !reach.is_finite() {
            return None;
        }
        while reach >= half {
            cube += 1;
            half *= 2.0;
            if cube >= self.cubes {
                return None;
            }
        }
        let place = (middle / half + 1.0) * f64::from(CELLS / 2);
        Some(Cell {
            cube,
            half,
            place,
            index: place.to_array().map(|v| (v as u32).min(CELLS - 1)),
        })
    }
}

/// The cell of a position.
struct Cell {
    cube: usize,
    /// Half the side of the cube.
    half: f64,
    /// The position in the cube, in cells.
    place: DVec3,
    index: [u32; 3],
}

impl Cell {
    fn bit(&self) -> usize {
        self.cube * VOLUME + morton(self.index)
    }

    fn is_filled(&self, grid: &Occupancy) -> bool {
        let bit = self.bit();
        grid.bits[bit / 64] >> (bit % 64) & 1 == 1
    }

    /// The length along a direction to the end of a block of `edge` cells an edge, less a margin
    /// far above what rounding moves a position. Blocks of up to 32 cells lie within the inner cube
    /// or outside, so that no other cube decides on what is within them.
    fn reach(&self, edge: u32, direction: DVec3) -> f64 {
        let cells = (0..3).map(|axis| {
            let first = f64::from(self.index[axis] / edge * edge);
            let rest = match direction[axis] > 0.0 {
                true => first + f64::from(edge) - self.place[axis],
                false => self.place[axis] - first,
            };
            (rest - MARGIN) / direction[axis].abs()
        });
        let cells = cells.fold(f64::INFINITY, f64::min).max(0.0);
        cells * self.half / f64::from(CELLS / 2)
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

    /// No length of empty space reaches a filled cell, in either cube, along any direction, and the
    /// walk takes far fewer steps than there are samples.
    #[test]
    fn empty_space_ends_before_the_next_filled_cell() {
        use rand::{Rng as _, SeedableRng as _};
        let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(7);
        let mut thickness = vec![0.0; 2 * VOLUME];
        for _ in 0..3000 {
            thickness[random.random_range(0..2 * VOLUME)] = 1.0;
        }
        let grid = Occupancy::new(&thickness);
        let (step, mut samples, mut steps, mut filled) = (1.0 / 1024.0, 0u64, 0u64, 0);
        for ray in 0..300 {
            let mut part = |range: std::ops::Range<f64>| random.random_range(range);
            let mut towards = DVec3::new(part(-1.0..1.0), part(-1.0..1.0), part(-1.0..1.0));
            if ray % 3 == 0 {
                // Along a face of cells.
                towards = DVec3::AXES[ray % 9 / 3];
            }
            let towards = towards.normalize();
            let mut origin = DVec3::new(part(-0.5..1.5), part(-0.5..1.5), part(-0.5..1.5));
            if ray % 2 == 0 {
                origin = (origin * 64.0).round() / 64.0;
            }
            let (mut k, at) = (0u64, |k: u64| origin + towards * (step * k as f64));
            while (at(k) - 0.5).abs().max_element() < 1.0 {
                steps += 1;
                let Some(empty) = grid.empty_for(at(k), towards) else {
                    assert!(grid.holds(at(k)));
                    (filled, samples, k) = (filled + 1, samples + 1, k + 1);
                    continue;
                };
                let next = k + 1 + (empty / step) as u64;
                for skipped in k..next {
                    assert!(!grid.holds(at(skipped)), "{origin} {towards} {k} {skipped}");
                }
                samples += next - k;
                k = next;
            }
        }
        assert!(
            filled > 10 && 4 * steps < samples,
            "{filled}, {steps} of {samples}"
        );
    }
}
