//! The alpha mask: a bit grid, written in training, of the vertices around which the field may be
//! non-empty.

use glam::DVec3;

/// Bits at the vertices of a separate grid.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub(super) struct AlphaMask {
    /// Number of vertices along x, y, z.
    pub(super) points: [usize; 3],
    /// Corners of the box whose faces contain the outer vertices.
    pub(super) bounds: [DVec3; 2],
    /// One bit a vertex, x fastest.
    pub(super) filled: Vec<bool>,
}

impl AlphaMask {
    /// Whether the trilinear interpolation of the bits at a world point is above 0. Bits outside
    /// the grid are 0.
    pub(super) fn holds(&self, at: DVec3) -> bool {
        let last = DVec3::from(self.points.map(|p| p as f64 - 1.0));
        let place = (at - self.bounds[0]) / (self.bounds[1] - self.bounds[0]) * last;
        if place.cmpge(DVec3::ZERO).all() && place.cmple(last).all() {
            return self.holds_within(place.to_array());
        }
        let low = place.floor();
        (0..8u32).any(|corner| {
            let mut vertex = low;
            for axis in 0..3 {
                if corner >> axis & 1 == 1 {
                    if place[axis] == low[axis] {
                        // No weight is left for the upper vertex.
                        return false;
                    }
                    vertex[axis] += 1.0;
                }
            }
            if !(vertex.cmpge(DVec3::ZERO).all() && vertex.cmple(last).all()) {
                return false;
            }
            let [x, y, z] = vertex.to_array().map(|v| v as usize);
            let index = x + self.points[0] * (y + self.points[1] * z);
            self.filled.get(index).copied().unwrap_or_default()
        })
    }

    /// The same within the grid: an upper vertex counts only if a weight is left for it.
    fn holds_within(&self, place: [f64; 3]) -> bool {
        let [nx, ny, _] = self.points;
        let [x, y, z] = place.map(|v| v as usize);
        let first = x + nx * (y + ny * z);
        let [x, y, z] = place.map(|v| v != (v as usize) as f64);
        let [x, y, z] = [
            usize::from(x),
            nx * usize::from(y),
            nx * ny * usize::from(z),
        ];
        let offsets = [0, x, y, x + y, z, x + z, y + z, x + y + z];
        let bit = |offset| self.filled.get(first + offset).copied().unwrap_or_default();
        offsets
            .into_iter()
            .fold(false, |any, offset| any | bit(offset))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Within the grid a place is filled if the weight of a set bit is above 0.
    #[test]
    fn within_the_grid_a_weight_decides() {
        let points = [3, 4, 5];
        for bit in 0..60 {
            let mut filled = vec![false; 60];
            filled[bit] = true;
            let mask = AlphaMask {
                points,
                bounds: [DVec3::ZERO, DVec3::new(2.0, 3.0, 4.0)],
                filled,
            };
            let own = [bit % 3, bit / 3 % 4, bit / 12].map(|v| v as f64);
            for n in 0..9 * 9 * 9 {
                let place = [n % 9, n / 9 % 9, n / 81];
                let place = [0, 1, 2].map(|axis| place[axis] as f64 * 0.5);
                if (0..3).any(|axis| place[axis] > points[axis] as f64 - 1.0) {
                    continue;
                }
                // The weight of the bit's vertex is above 0.
                let expected = (0..3).all(|axis| (place[axis] - own[axis]).abs() < 1.0);
                assert_eq!(mask.holds_within(place), expected, "{bit} {place:?}");
                assert_eq!(mask.holds(DVec3::from(place)), expected, "{bit} {place:?}");
            }
        }
    }

    /// One bit fills the eight cells around it and nothing else.
    #[test]
    fn a_bit_reaches_its_neighbours() {
        let mut filled = vec![false; 3 * 4 * 5];
        filled[1 + 3 * (2 + 4 * 3)] = true;
        let mask = AlphaMask {
            points: [3, 4, 5],
            bounds: [DVec3::ZERO, DVec3::new(2.0, 3.0, 4.0)],
            filled,
        };
        let centre = DVec3::new(1.0, 2.0, 3.0);
        assert!(mask.holds(centre));
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                let mut at = centre;
                at[axis] += 0.99 * side;
                assert!(mask.holds(at), "{at}");
                at[axis] = centre[axis] + side;
                assert!(!mask.holds(at), "{at}");
            }
        }
        assert!(!mask.holds(DVec3::NAN));
        assert!(!mask.holds(DVec3::splat(f64::INFINITY)));
    }

    /// Just outside, the vertices of a face still count, as zero padding does.
    #[test]
    fn beyond_the_grid_all_is_empty() {
        let mask = AlphaMask {
            points: [2, 2, 2],
            bounds: [DVec3::ZERO, DVec3::ONE],
            filled: vec![true; 8],
        };
        assert!(mask.holds(DVec3::new(-0.5, 0.5, 0.5)));
        assert!(!mask.holds(DVec3::new(-1.0, 0.5, 0.5)));
        assert!(!mask.holds(DVec3::new(0.5, 0.5, 2.0)));
    }
}
