//! The nearest of many points.

use glam::DVec3;

/// Points of a leaf, at most.
const LEAF: usize = 8;

/// A k-d tree: each part of `order` is split at its middle along its widest axis.
#[derive(Debug)]
pub(crate) struct Tree {
    points: Vec<DVec3>,
    order: Vec<usize>,
    /// Axis of each part, by the place of its middle.
    axes: Vec<u8>,
}

impl Tree {
    pub(crate) fn of(points: Vec<DVec3>) -> Self {
        let mut order: Vec<usize> = (0..points.len()).collect();
        let mut axes = vec![0; points.len()];
        let whole = 0..points.len();
        let mut parts = vec![whole];
        while let Some(part) = parts.pop() {
            if part.len() <= LEAF {
                continue;
            }
            let own = &mut order[part.clone()];
            let low = own
                .iter()
                .fold(DVec3::INFINITY, |low, i| low.min(points[*i]));
            let high = own
                .iter()
                .fold(DVec3::NEG_INFINITY, |high, i| high.max(points[*i]));
            let wide = (high - low).to_array();
            let axis = (0..3)
                .max_by(|a, b| wide[*a].total_cmp(&wide[*b]))
                .unwrap_or(0);
            let half = own.len() / 2;
            own.select_nth_unstable_by(half, |a, b| points[*a][axis].total_cmp(&points[*b][axis]));
            let middle = part.start + half;
            axes[middle] = axis as u8;
            parts.extend([part.start..middle, middle + 1..part.end]);
        }
        Self {
            points,
            order,
            axes,
        }
    }

    /// The index of the nearest point; of several the lowest.
    pub(crate) fn nearest(&self, to: DVec3) -> usize {
        let mut best = (f64::INFINITY, usize::MAX);
        let consider = |best: &mut (f64, usize), at: usize| {
            let index = self.order[at];
            let own = (self.points[index].distance_squared(to), index);
            if own.0 < best.0 || (own.0 == best.0 && own.1 < best.1) {
                *best = own;
            }
        };
        // Parts, and the square of their least distance.
        let mut parts = vec![(0..self.order.len(), 0.0)];
        while let Some((part, least)) = parts.pop() {
            if least > best.0 {
                continue;
            }
            if part.len() <= LEAF {
                part.for_each(|at| consider(&mut best, at));
                continue;
            }
            let middle = part.start + part.len() / 2;
            consider(&mut best, middle);
            let axis = usize::from(self.axes[middle]);
            let off = to[axis] - self.points[self.order[middle]][axis];
            let [near, far] = match off < 0.0 {
                true => [part.start..middle, middle + 1..part.end],
                false => [middle + 1..part.end, part.start..middle],
            };
            parts.push((far, off * off));
            parts.push((near, least));
        }
        best.1
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn no_point_is_nearer(
            points in proptest::collection::vec(proptest::array::uniform3(-4i8..4), 1..80),
            to in proptest::array::uniform3(-5i8..5),
        ) {
            let of = |p: [i8; 3]| DVec3::from(p.map(f64::from));
            let all: Vec<DVec3> = points.into_iter().map(of).collect();
            let found = Tree::of(all.clone()).nearest(of(to));
            let expected = (0..all.len()).min_by(|a, b| {
                all[*a].distance_squared(of(to)).total_cmp(&all[*b].distance_squared(of(to)))
            });
            prop_assert_eq!(Some(found), expected);
        }
    }
}
