//! A grid that marks where a field may be non-empty.

use std::fmt;
use std::sync::OnceLock;

use glam::DVec3;

/// A separate grid that marks where the field may be non-empty.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Mask {
    /// Number of vertices along x, y, z.
    pub points: [usize; 3],
    /// One flag a vertex, x fastest.
    pub filled: Vec<bool>,
    /// Scale from field vertices to mask vertices.
    pub scale: DVec3,
    /// Offset added after scaling.
    pub shift: DVec3,
}

impl Mask {
    /// Whether the nearest vertex is filled; `false` outside the mask.
    #[must_use]
    pub fn holds(&self, at: DVec3) -> bool {
        let place = (at * self.scale + self.shift).to_array();
        let mut index = 0;
        for axis in [2, 1, 0] {
            let Some(vertex) = nearest(place[axis], self.points[axis]) else {
                return false;
            };
            index = index * self.points[axis] + vertex;
        }
        self.filled.get(index).copied().unwrap_or_default()
    }
}

/// Vertices along an edge of a block.
const BLOCK: usize = 8;
/// A block's distance from its faces within which positions are looked up one by one, in vertices:
/// far above what rounding moves a position.
const MARGIN: f64 = 1e-6;

/// Blocks of vertices of a mask: whether any of them is filled. Found when first asked for, so that
/// any two of a mask are equal, and a copy finds its own.
#[derive(Default)]
pub(crate) struct Blocks(OnceLock<Vec<bool>>);

impl Clone for Blocks {
    fn clone(&self) -> Self {
        Self::default()
    }
}

impl PartialEq for Blocks {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl fmt::Debug for Blocks {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Blocks")
    }
}

impl Blocks {
    /// The length along a direction from a position in field vertices on which a mask is empty, or
    /// `None` where it is filled. `direction` is in field vertices a unit of length. The length ends
    /// before the block of empty vertices does.
    pub(crate) fn empty_for(&self, mask: &Mask, at: DVec3, direction: DVec3) -> Option<f64> {
        let place = (at * mask.scale + mask.shift).to_array();
        let mut index = 0;
        let mut first = [0.0; 3];
        for axis in [2, 1, 0] {
            let Some(vertex) = nearest(place[axis], mask.points[axis]) else {
                return Some(0.0);
            };
            index = index * mask.points[axis].div_ceil(BLOCK) + vertex / BLOCK;
            first[axis] = (vertex / BLOCK * BLOCK) as f64 - 0.5;
        }
        let filled = self.0.get_or_init(|| mask.blocks());
        if filled.get(index).copied().unwrap_or(true) {
            return (!mask.holds(at)).then_some(0.0);
        }
        let towards = (direction * mask.scale).to_array();
        let lengths = (0..3).map(|axis| {
            let rest = match towards[axis] > 0.0 {
                true => first[axis] + BLOCK as f64 - place[axis],
                false => place[axis] - first[axis],
            };
            (rest - MARGIN) / towards[axis].abs()
        });
        Some(lengths.fold(f64::INFINITY, f64::min).max(0.0))
    }
}

impl Mask {
    /// Whether any vertex of each block is filled, x fastest.
    fn blocks(&self) -> Vec<bool> {
        let [wide, high, deep] = self.points.map(|points| points.div_ceil(BLOCK));
        let [nx, ny, _] = self.points;
        let mut blocks = vec![false; wide * high * deep];
        for (i, _) in self
            .filled
            .iter()
            .enumerate()
            .filter(|(_, filled)| **filled)
        {
            let [x, y, z] = [i % nx, i / nx % ny, i / (nx * ny)].map(|v| v / BLOCK);
            blocks[x + wide * (y + high * z)] = true;
        }
        blocks
    }
}

/// The nearest of `points` vertices, halves away from 0; `None` outside.
#[inline]
fn nearest(place: f64, points: usize) -> Option<usize> {
    let last = points as f64 - 1.0;
    if !(place > -0.5 && place < last + 0.5) {
        return None;
    }
    // Below 0 the nearest is 0, as a conversion without sign gives.
    let below = place as usize;
    Some(below + usize::from(place - below as f64 >= 0.5))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As rounding does, next to halves, at the ends and beyond.
    #[test]
    fn the_nearest_vertex_is_the_rounded_place() {
        let halves = (-6..24).map(|n| f64::from(n) / 4.0);
        let around = halves.flat_map(|v| [v.next_down(), v, v.next_up()]);
        let far = [-1e300, 1e300, f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
        for place in around.chain(far) {
            let near = place.round();
            let expected = (0.0..=3.0).contains(&near).then_some(near as usize);
            assert_eq!(nearest(place, 4), expected, "{place}");
        }
    }

    /// No length of empty space reaches a filled vertex, along any direction, with masks of any
    /// scale, and the walk takes far fewer steps than there are samples.
    #[test]
    fn empty_space_ends_before_the_next_filled_vertex() {
        use rand::{Rng as _, SeedableRng as _};
        let mut random = rand_pcg::Pcg64Mcg::seed_from_u64(11);
        let points = [37, 24, 41];
        let (mut samples, mut steps, mut filled) = (0u64, 0u64, 0);
        for round in 0..40 {
            let mut part = |range: std::ops::Range<f64>| random.random_range(range);
            let exact = round % 2 == 0;
            let scale = if exact {
                DVec3::ONE
            } else {
                DVec3::new(part(0.3..2.0), part(0.3..2.0), 1.0)
            };
            let shift = if exact {
                DVec3::ZERO
            } else {
                DVec3::splat(part(-1.0..1.0))
            };
            let mask = Mask {
                points,
                filled: (0..37 * 24 * 41).map(|_| part(0.0..1.0) < 1e-3).collect(),
                scale,
                shift,
            };
            let blocks = Blocks::default();
            for ray in 0..30 {
                let mut towards = DVec3::new(part(-1.0..1.0), part(-1.0..1.0), part(-1.0..1.0));
                if ray % 3 == 0 {
                    towards = DVec3::AXES[ray % 9 / 3];
                }
                let mut origin = DVec3::new(part(0.0..37.0), part(0.0..24.0), part(0.0..41.0));
                if ray % 2 == 0 {
                    origin = (origin * 2.0).round() / 2.0;
                }
                let (step, mut k) = (0.5, 0u64);
                let at = |k: u64| origin + towards * (step * k as f64);
                while k < 60 {
                    steps += 1;
                    let Some(empty) = blocks.empty_for(&mask, at(k), towards) else {
                        assert!(mask.holds(at(k)));
                        (filled, samples, k) = (filled + 1, samples + 1, k + 1);
                        continue;
                    };
                    let next = k + 1 + (empty / step) as u64;
                    for skipped in k..next {
                        assert!(
                            !mask.holds(at(skipped)),
                            "{round} {origin} {towards} {skipped}"
                        );
                    }
                    samples += next - k;
                    k = next;
                }
            }
        }
        assert!(
            filled > 10 && steps < samples,
            "{filled}, {steps} of {samples}"
        );
    }
}
