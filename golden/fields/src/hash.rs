//! Hashing of vertices (Müller et al. 2022), by vertex or by block.

use serde::Deserialize;

/// Factors of a vertex's coordinates in its hash (Teschner et al. 2003; the first is 1 in
/// Instant-NGP).
const PRIMES: [u32; 3] = [1, 2_654_435_761, 805_459_861];

/// The unit that shares an entry of a hashed table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum HashUnit {
    /// A vertex, as in Instant-NGP.
    #[default]
    Vertex,
    /// A block of 8 x 8 x 8 vertices, x fastest: an MVoxel. Other vertices collide than with
    /// single vertices, so a model must be fitted for it.
    MVoxel,
}

impl HashUnit {
    /// Vertices an edge of a block.
    pub const BLOCK: usize = 8;
    /// Rows of a block.
    pub(crate) const BLOCK_ROWS: usize = Self::BLOCK.pow(3);

    /// Its name in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Vertex => "vertex",
            Self::MVoxel => "mvoxel",
        }
    }

    /// Rows in an entry.
    pub(super) const fn rows(self) -> usize {
        match self {
            Self::Vertex => 1,
            Self::MVoxel => Self::BLOCK_ROWS,
        }
    }

    /// The row of a vertex in a hashed table of `rows` rows.
    pub(super) fn row(self, vertex: [usize; 3], rows: usize) -> usize {
        let [x, y, z] = [0, 1, 2].map(|axis| self.along(axis, vertex[axis]));
        self.joined([x, y, z], rows)
    }

    /// What a coordinate contributes to the row of a vertex.
    #[inline(always)]
    pub(super) fn along(self, axis: usize, coordinate: usize) -> Along {
        match self {
            Self::Vertex => Along {
                hash: (coordinate as u32).wrapping_mul(PRIMES[axis]),
                row: 0,
            },
            Self::MVoxel => Along {
                hash: ((coordinate / Self::BLOCK) as u32).wrapping_mul(PRIMES[axis]),
                row: coordinate % Self::BLOCK * Self::BLOCK.pow(axis as u32),
            },
        }
    }

    /// The row of a vertex in a hashed table of `rows` rows, from its coordinates.
    #[inline(always)]
    pub(super) fn joined(self, [x, y, z]: [Along; 3], rows: usize) -> usize {
        let hash = (x.hash ^ y.hash ^ z.hash) as usize;
        match self {
            Self::Vertex => reduced(hash, rows),
            Self::MVoxel => {
                let entry = reduced(hash, rows / Self::BLOCK_ROWS);
                entry * Self::BLOCK_ROWS + x.row + y.row + z.row
            }
        }
    }
}

/// A hash modulo a number of entries. A division takes as long as the rest of a gathered row.
#[inline(always)]
const fn reduced(hash: usize, entries: usize) -> usize {
    match entries.is_power_of_two() {
        true => hash & (entries - 1),
        false => hash % entries,
    }
}

/// What a coordinate contributes to the row of a vertex.
#[derive(Debug, Clone, Copy)]
pub(super) struct Along {
    /// The coordinate, or that of its block, times the axis's prime.
    hash: u32,
    /// Rows from the first of the entry.
    row: usize,
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The hash of a vertex, before reduction to the size of a table.
    fn hash(vertex: [usize; 3]) -> u32 {
        let parts = [0, 1, 2].map(|axis| HashUnit::Vertex.along(axis, vertex[axis]).hash);
        parts[0] ^ parts[1] ^ parts[2]
    }

    /// By hand: 3, 5 and 7 times their primes modulo 2^32.
    #[test]
    fn vertices_hash_as_computed_by_hand() {
        assert_eq!(hash([0, 0, 0]), 0);
        assert_eq!(hash([9, 0, 0]), 9);
        assert_eq!(hash([0, 1, 0]), 0x9e37_79b1);
        assert_eq!(hash([0, 0, 1]), 0x3002_5795);
        // 5 x 0x9e3779b1 = 0x3_1715_6075, 7 x 0x30025795 = 0x1_5010_6513.
        assert_eq!(hash([3, 5, 7]), 3 ^ 0x1715_6075 ^ 0x5010_6513);
        assert_eq!(HashUnit::Vertex.row([3, 5, 7], 256), 3 ^ 0x75 ^ 0x13);
    }

    /// By hand: the blocks of vertices (3, 41, 58) and (10, 0, 7) are (0, 5, 7) and
    /// (1, 0, 0).
    #[test]
    fn blocks_hash_as_one() {
        let rows = 4 * HashUnit::BLOCK_ROWS;
        let row = |vertex| HashUnit::MVoxel.row(vertex, rows);
        // 5 x ..b1 and 7 x ..95 modulo 4: 1 and 3.
        let entry = 1 ^ 3;
        assert_eq!(row([3, 41, 58]), 512 * entry + 3 + 8 * (1 + 8 * 2));
        assert_eq!(row([10, 0, 7]), 512 + 2 + 8 * (8 * 7));
    }
}
