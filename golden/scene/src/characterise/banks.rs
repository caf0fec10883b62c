//! Bank conflicts, for several numbers of lanes and banks at once.

use schemars::JsonSchema;
use serde::Serialize;

use super::ratio;

/// Numbers of lanes side by side, each twice the one before; the paper's is the first.
pub const LANES: [usize; 3] = [16, 32, 64];
/// Numbers of banks, all powers of two; the paper's is the first, and the last is the number of
/// bits in a set.
pub const BANKS: [u32; 4] = [16, 32, 64, 128];
/// Number of lanes counted at a time.
pub(super) const BLOCK: usize = LANES[2];

/// Bank statistics of a feature-major buffer. Vector `v` lies wholly in bank `v mod banks` (the
/// layout that the paper argues against), and a bank serves one vector a round. Lanes that read
/// the same vector share it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Banks {
    /// Number of reads.
    pub reads: u64,
    /// Reads that wait for another vector of their bank in the same round.
    pub conflicts: u64,
}

impl Banks {
    /// Ratio of conflicts to reads.
    #[must_use]
    pub fn conflict_rate(&self) -> f64 {
        ratio(self.conflicts, self.reads)
    }
}

/// Conflicts by [`LANES`], then by [`BANKS`].
pub(super) type Conflicts = [[u64; BANKS.len()]; LANES.len()];

/// Cells of the hash set, more than twice its elements.
const CELLS: usize = 256;

/// Distinct vectors of a round, and their banks.
struct Round {
    /// For each cell, the round in which it was written, and the vector.
    cells: [(u32, u32); CELLS],
    number: u32,
    different: u64,
    banks: u128,
}

impl Round {
    const fn new() -> Self {
        Self {
            cells: [(0, 0); CELLS],
            number: 1,
            different: 0,
            banks: 0,
        }
    }

    /// Adds a vector; returns whether it is new in this round.
    fn add(&mut self, vector: u32) -> bool {
        let mut cell = (vector.wrapping_mul(0x9e37_79b1) >> 24) as usize;
        while self.cells[cell].0 == self.number {
            if self.cells[cell].1 == vector {
                return false;
            }
            cell = (cell + 1) % CELLS;
        }
        self.cells[cell] = (self.number, vector);
        self.different += 1;
        self.banks |= 1 << (vector % u128::BITS);
        true
    }

    /// Ends the round and adds the waiting vectors by [`BANKS`].
    fn end(&mut self, conflicts: &mut [u64; BANKS.len()]) {
        for (sum, banks) in conflicts.iter_mut().zip(BANKS) {
            let mut set = self.banks;
            let mut bits = u128::BITS;
            while bits > banks {
                bits /= 2;
                set = (set | set >> bits) & ((1 << bits) - 1);
            }
            *sum += self.different - u64::from(set.count_ones());
        }
        (self.different, self.banks) = (0, 0);
        self.number += 1;
    }
}

/// Counts the conflicts of at most [`BLOCK`] lanes with their lists of reads.
pub(super) fn conflicts(lanes: &[&[u32]]) -> Conflicts {
    let mut found = Conflicts::default();
    let mut rounds = [const { Round::new() }; LANES.len()];
    let longest = lanes.iter().map(|lane| lane.len()).max().unwrap_or(0);
    for step in 0..longest {
        for (i, lane) in lanes.iter().enumerate() {
            if let Some(vector) = lane.get(step) {
                // What is not new to fewer lanes is not new to more.
                let _ = rounds.iter_mut().all(|round| round.add(*vector));
            }
            for ((round, lanes), sums) in rounds.iter_mut().zip(LANES).zip(&mut found) {
                if (i + 1) % lanes == 0 {
                    round.end(sums);
                }
            }
        }
        for (round, sums) in rounds.iter_mut().zip(&mut found) {
            round.end(sums);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn lanes_share_a_vector_and_wait_for_another_of_its_bank() {
        let lists: [&[u32]; 4] = [&[0, 1], &[16, 1], &[32, 3], &[5]];
        let found = conflicts(&lists);
        // 0, 16 and 32 are one bank of 16; 0 and 32 one of 32; then 1 is shared.
        assert_eq!(found, [[2, 1, 0, 0]; 3]);
        // Side by side, or in two turns.
        let mut far = vec![&[7u32][..]; 17];
        far[16] = &[23];
        assert_eq!(conflicts(&far), [[0; 4], [1, 0, 0, 0], [1, 0, 0, 0]]);
    }

    /// Round for round, with sets.
    fn slowly(lanes: &[&[u32]]) -> Conflicts {
        use std::collections::BTreeSet;
        let mut found = Conflicts::default();
        for (sums, side) in found.iter_mut().zip(LANES) {
            for group in lanes.chunks(side) {
                for step in 0..100 {
                    let round = group.iter().filter_map(|lane| lane.get(step));
                    let round: BTreeSet<u32> = round.copied().collect();
                    for (sum, banks) in sums.iter_mut().zip(BANKS) {
                        let used: BTreeSet<u32> = round.iter().map(|v| v % banks).collect();
                        *sum += (round.len() - used.len()) as u64;
                    }
                }
            }
        }
        found
    }

    proptest! {
        #[test]
        fn conflicts_are_those_of_each_round(
            lanes in prop::collection::vec(prop::collection::vec(0u32..700, 0..9), 0..=BLOCK),
        ) {
            let lanes: Vec<&[u32]> = lanes.iter().map(|lane| &lane[..]).collect();
            prop_assert_eq!(conflicts(&lanes), slowly(&lanes));
        }
    }
}
