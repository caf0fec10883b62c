//! Merging the cells of a uniform partition, 2 x 2 x 2 at a time, as long as their contents fit an
//! MVoxel (paper, Sec. "Memory Optimizations": 7.2 points an MVoxel before merging, 172.8 after).

use std::collections::{BTreeMap, HashMap};

use super::partition::Partition;
use potamoi_gaussians::Cloud;

/// Bytes of a node in memory: a mask of existing children and the index of the first, or the index
/// of the first record and the number of records.
const NODE_BYTES: usize = 8;

/// A partition with merged cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Octree {
    /// For each non-empty cell, the lowest cell of its MVoxel.
    owner: HashMap<[u32; 3], [u32; 3]>,
    before: Vec<usize>,
    points: Vec<usize>,
    nodes: usize,
}

/// A cube of cells at one level of the tree.
struct Cube {
    /// Number of Gaussians; `None` if the cube is not a single MVoxel.
    points: Option<usize>,
    /// Non-empty cells.
    cells: Vec<[u32; 3]>,
}

impl Octree {
    /// Merges bottom-up: eight neighbours become one if each of them is a single MVoxel at most
    /// and together they hold at most `rows` Gaussians.
    #[must_use]
    pub fn merge(cloud: &Cloud, partition: &Partition, rows: usize) -> Self {
        let mut level: BTreeMap<[u32; 3], Cube> = BTreeMap::new();
        for mean in cloud.means() {
            let cell = partition.cell(*mean);
            let cube = level.entry(cell).or_insert_with(|| Cube {
                points: Some(0),
                cells: vec![cell],
            });
            cube.points = cube.points.map(|n| n + 1);
        }
        let mut tree = Self {
            owner: HashMap::new(),
            before: level.values().filter_map(|cube| cube.points).collect(),
            points: vec![],
            nodes: 0,
        };
        while level.len() > 1 {
            tree.nodes += level.len();
            let mut above: BTreeMap<[u32; 3], Vec<Cube>> = BTreeMap::new();
            for (at, cube) in level {
                above.entry(at.map(|c| c / 2)).or_default().push(cube);
            }
            level = above
                .into_iter()
                .map(|(at, children)| (at, tree.join(children, rows)))
                .collect();
        }
        tree.nodes += level.len();
        for cube in level.into_values() {
            tree.settle(cube);
        }
        tree
    }

    /// Joins up to eight cubes: merges them, or settles each on its own.
    fn join(&mut self, children: Vec<Cube>, rows: usize) -> Cube {
        let total: Option<usize> = children.iter().map(|c| c.points).sum();
        if let Some(points) = total.filter(|n| *n <= rows) {
            // The children are nodes no more.
            self.nodes -= children.len();
            return Cube {
                points: Some(points),
                cells: children.into_iter().flat_map(|c| c.cells).collect(),
            };
        }
        for child in children {
            self.settle(child);
        }
        Cube {
            points: None,
            cells: vec![],
        }
    }

    /// Makes an MVoxel of a cube that is not merged further.
    fn settle(&mut self, cube: Cube) {
        let Some(points) = cube.points else { return };
        self.points.push(points);
        if let Some(own) = cube.cells.iter().min().copied() {
            self.owner
                .extend(cube.cells.iter().map(|cell| (*cell, own)));
        }
    }

    /// The cell that represents the MVoxel of a cell.
    #[must_use]
    pub fn owner(&self, cell: [u32; 3]) -> [u32; 3] {
        self.owner.get(&cell).copied().unwrap_or(cell)
    }

    /// Gaussians in each non-empty cell, before merging.
    #[must_use]
    pub fn cells(&self) -> &[usize] {
        &self.before
    }

    /// Gaussians in each MVoxel, after merging.
    #[must_use]
    pub fn points(&self) -> &[usize] {
        &self.points
    }

    /// Bytes of the tree in memory.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.nodes * NODE_BYTES
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::partition::at_centres as cloud;
    use proptest::prelude::*;

    /// Two dense corners keep the grid fine; the sparse rest is joined.
    #[test]
    fn sparse_neighbours_are_joined_and_dense_ones_not() {
        let mut means: Vec<[f32; 3]> = (0..64)
            .map(|i| [i % 4, i / 4 % 4, i / 16].map(|v| v as f32 + 0.5))
            .collect();
        means.extend([[0.5, 0.5, 0.5]; 30]);
        means.push([0.0; 3]);
        means.push([4.0; 3]);
        let cloud = cloud(means);
        let fine = Partition::coarsest(&cloud, 40);
        assert_eq!(fine.cells, [2; 3]);
        let tree = Octree::merge(&cloud, &fine, 64);
        assert_eq!(tree.points().iter().sum::<usize>(), cloud.len());
        // All 96 do not fit 64; the eight cells stay apart.
        assert_eq!(tree.points().len(), 8);
        let tree = Octree::merge(&cloud, &fine, 96);
        assert_eq!(tree.points(), [96]);
        assert_eq!(tree.bytes(), 8);
        assert_eq!(tree.owner([1, 1, 1]), [0, 0, 0]);
    }

    proptest! {
        #[test]
        fn mvoxels_hold_everything_once_and_no_more_than_fits(
            means in proptest::collection::vec(any::<[u8; 3]>(), 1..300), rows in 1usize..60
        ) {
            let cloud = cloud(means.iter().map(|m| m.map(f32::from)).collect());
            let partition = Partition::coarsest(&cloud, rows);
            let tree = Octree::merge(&cloud, &partition, rows);
            prop_assert_eq!(tree.points().iter().sum::<usize>(), cloud.len());
            prop_assert_eq!(tree.cells().iter().sum::<usize>(), cloud.len());
            let mut found: HashMap<[u32; 3], usize> = HashMap::new();
            for mean in cloud.means() {
                let owner = tree.owner(partition.cell(*mean));
                // An owner is its own.
                prop_assert_eq!(tree.owner(owner), owner);
                *found.entry(owner).or_default() += 1;
            }
            let mut counts: Vec<usize> = found.values().copied().collect();
            let mut listed = tree.points().to_vec();
            counts.sort_unstable();
            listed.sort_unstable();
            prop_assert_eq!(counts, listed);
            let most = rows.max(partition.fullest);
            prop_assert!(tree.points().iter().all(|n| *n <= most));
            prop_assert!(tree.points().len() <= tree.cells().len());
        }
    }
}
