//! Rows of a memory, with pseudo-random initial contents.

use std::collections::BTreeMap;

use super::words;

/// Largest memory that is allocated densely, in words (32 MiB).
const DENSE: u64 = 1 << 22;

/// Pseudo-random number for a seed and an index.
pub(super) fn scramble(seed: u64, index: u64) -> u64 {
    // SplitMix64, whose steps can be taken in any order.
    let mut x = seed.wrapping_add(index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15));
    x = (x ^ x >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ x >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ x >> 31
}

/// Rows of a memory: dense, or only those written.
#[derive(Debug, Clone)]
pub(super) struct Rows {
    depth: u32,
    width: u32,
    seed: u64,
    dense: Vec<u64>,
    sparse: BTreeMap<u32, Vec<u64>>,
}

impl Rows {
    pub(super) fn new(depth: u32, width: u32, seed: u64) -> Self {
        let mut rows = Self {
            depth,
            width,
            seed,
            dense: vec![],
            sparse: BTreeMap::new(),
        };
        let count = words::count(width);
        if u64::from(depth) * count as u64 <= DENSE {
            let mut all = vec![0; depth as usize * count];
            for (row, out) in all.chunks_mut(count).enumerate() {
                rows.initial(row as u32, out);
            }
            rows.dense = all;
        }
        rows
    }

    fn initial(&self, row: u32, out: &mut [u64]) {
        for (i, o) in out.iter_mut().enumerate() {
            *o = scramble(self.seed, u64::from(row) << 11 | i as u64);
        }
        words::trim(out, self.width);
    }

    /// The row, or zeros past the depth.
    pub(super) fn read(&self, row: u32, out: &mut [u64]) {
        let at = row as usize * out.len();
        if row >= self.depth {
            out.fill(0);
        } else if !self.dense.is_empty() {
            out.copy_from_slice(&self.dense[at..at + out.len()]);
        } else if let Some(written) = self.sparse.get(&row) {
            out.copy_from_slice(written);
        } else {
            self.initial(row, out);
        }
    }

    /// Writes a row; rows past the depth are ignored.
    pub(super) fn write(&mut self, row: u32, data: &[u64]) {
        let at = row as usize * data.len();
        if row >= self.depth {
        } else if self.dense.is_empty() {
            self.sparse.insert(row, data.to_vec());
        } else {
            self.dense[at..at + data.len()].copy_from_slice(data);
        }
    }
}
