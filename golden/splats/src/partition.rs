//! The uniform partition of a splat scene into MVoxels.

use std::collections::HashMap;

use potamoi_gaussians::Cloud;

/// The finest grid, in cells along the longest side.
const FINEST: u32 = 256;

/// The division of a cloud into MVoxels.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Cells {
    /// How many times the sides of the coarsest grid that fits are halved, at most 8.
    pub halvings: u32,
    /// Whether cells are merged as long as they fit an MVoxel.
    pub merge: bool,
}

impl Cells {
    /// The coarsest grid, merged.
    pub const MERGED: Self = Self {
        halvings: 0,
        merge: true,
    };
}

/// A grid of cubic cells over the centres of a cloud (paper, Sec. "Memory
/// Optimizations": a uniform partition whose cells fit on chip).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Partition {
    /// Number of cells along x, y, z.
    pub cells: [u32; 3],
    /// Side of a cell.
    pub side: f64,
    /// Number of Gaussians in the fullest cell.
    pub fullest: usize,
    origin: [f64; 3],
}

impl Partition {
    /// The coarsest grid whose fullest cell holds at most `rows` Gaussians. If a cell of the
    /// finest grid, 256 along the longest side, still holds more (many Gaussians in one place),
    /// that grid is used and the cell becomes several MVoxels.
    #[must_use]
    pub fn coarsest(cloud: &Cloud, rows: usize) -> Self {
        // n cells a side hold n^3 * rows Gaussians at most.
        let least = (1..FINEST).find(|n| (*n as usize).pow(3).saturating_mul(rows) >= cloud.len());
        for n in least.unwrap_or(FINEST)..FINEST {
            let grid = Self::uniform(cloud, n);
            if let Some(fullest) = grid.count(cloud, rows) {
                return Self { fullest, ..grid };
            }
        }
        let grid = Self::uniform(cloud, FINEST);
        let fullest = grid.count(cloud, usize::MAX).unwrap_or(cloud.len());
        Self { fullest, ..grid }
    }

    /// The coarsest grid with sides halved `halvings` times, at most 8.
    #[must_use]
    pub fn halved(cloud: &Cloud, rows: usize, halvings: u32) -> Self {
        let coarsest = Self::coarsest(cloud, rows);
        if halvings == 0 {
            return coarsest;
        }
        let along_longest = coarsest.cells.into_iter().max().unwrap_or(1);
        let grid = Self::uniform(cloud, along_longest << halvings.min(8));
        let fullest = grid.count(cloud, usize::MAX).unwrap_or(cloud.len());
        Self { fullest, ..grid }
    }

    fn uniform(cloud: &Cloud, along_longest: u32) -> Self {
        let [low, high] = cloud.bounds().map(|p| p.map(f64::from));
        let extent = [0, 1, 2].map(|a| high[a] - low[a]);
        let longest = extent.into_iter().fold(0.0, f64::max);
        let side = longest / f64::from(along_longest);
        Self {
            cells: extent.map(|e| {
                let cells = (e / side).ceil();
                // NaN where all centres coincide.
                if cells >= 1.0 {
                    (cells as u32).min(along_longest)
                } else {
                    1
                }
            }),
            side,
            fullest: 0,
            origin: low,
        }
    }

    /// The cell that contains a centre.
    #[must_use]
    pub fn cell(&self, mean: [f32; 3]) -> [u32; 3] {
        [0, 1, 2].map(|a| {
            let place = ((f64::from(mean[a]) - self.origin[a]) / self.side).floor();
            // A cast of NaN gives 0, of a negative number 0.
            (place as u32).min(self.cells[a] - 1)
        })
    }

    /// Number of Gaussians in the fullest cell; `None` if above `limit`.
    fn count(&self, cloud: &Cloud, limit: usize) -> Option<usize> {
        let mut counts: HashMap<[u32; 3], usize> = HashMap::new();
        let mut fullest = 0;
        for mean in cloud.means() {
            let n = counts.entry(self.cell(*mean)).or_default();
            *n += 1;
            fullest = fullest.max(*n);
            if fullest > limit {
                return None;
            }
        }
        Some(fullest)
    }
}

/// Gaussians that differ only in their centres.
#[cfg(test)]
#[allow(clippy::unwrap_used)]
pub(crate) fn at_centres(means: Vec<[f32; 3]>) -> Cloud {
    let n = means.len();
    let (three, four) = (vec![[0.0; 3]; n], vec![[0.0; 4]; n]);
    Cloud::new(0, means, three.clone(), four, vec![0.0; n], three).unwrap()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::at_centres as cloud;
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn one_place_is_one_cell_however_full() {
        let p = Partition::coarsest(&cloud(vec![[1.0, 2.0, 3.0]; 40]), 16);
        assert_eq!((p.cells, p.fullest), ([1; 3], 40));
        assert_eq!(p.cell([1.0, 2.0, 3.0]), [0; 3]);
    }

    #[test]
    fn a_far_outlier_does_not_explode_the_grid() {
        let mut means = vec![[0.0, 0.0, 0.0]; 3];
        means.push([1e30, -1e30, 1e38]);
        let p = Partition::coarsest(&cloud(means), 2);
        assert_eq!((p.cells[2], p.fullest), (256, 3));
    }

    #[test]
    fn a_row_of_points_is_cut_along_its_length_alone() {
        let means = (0..100).map(|i| [0.0, i as f32, 0.0]).collect();
        let p = Partition::coarsest(&cloud(means), 10);
        assert_eq!((p.cells, p.fullest), ([1, 10, 1], 10));
    }

    proptest! {
        #[test]
        fn the_grid_is_the_coarsest_that_fits(
            means in proptest::collection::vec(any::<[u8; 3]>(), 1..200), rows in 1usize..20
        ) {
            let c = cloud(means.iter().map(|m| m.map(f32::from)).collect());
            let found = Partition::coarsest(&c, rows);
            let fits = |n| Partition::uniform(&c, n).count(&c, rows).is_some();
            let n = found.cells.into_iter().max().unwrap();
            if found.fullest <= rows {
                prop_assert!((1..n).all(|coarser| !fits(coarser)));
            } else {
                prop_assert!((1..FINEST).all(|any| !fits(any)));
            }
            // Each cell lies in one of the grid of twice its side.
            let halved = Partition::halved(&c, rows, 1);
            prop_assert!(halved.fullest <= found.fullest);
            if found.side > 0.0 {
                prop_assert_eq!(halved.side, found.side / 2.0);
            }
            for mean in c.means() {
                let within = halved.cell(*mean).map(|at| at / 2);
                prop_assert!((0..3).all(|a| within[a].min(found.cells[a] - 1) == found.cell(*mean)[a]));
                let cell = found.cell(*mean);
                prop_assert!((0..3).all(|a| cell[a] < found.cells[a]));
            }
        }
    }
}
