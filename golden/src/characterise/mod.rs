//! The paper's motivation figures, counted on the accesses of a frame rendered
//! in pixel-centric order (Sec. "Motivation", "DRAM Access Inefficiency" and
//! "SRAM Access Inefficiency").
//!
//! What is counted is feature vectors, whole ones: of a vertex, or of a
//! Gaussian. Rays, or the tiles of splats, go on side by side in *lanes*: in
//! every round each lane that is not done reads its next vector.

mod fields;
mod full_size;
mod splat_traffic;
mod splats;
mod stages;
mod tables;
mod traffic;

use std::collections::BTreeSet;

use serde::Serialize;
#[cfg(test)]
use {crate::fields::Field, glam::DVec3};

pub use fields::field_accesses;
pub use full_size::{FullSize, Size};
pub use splat_traffic::splat_traffic;
pub use splats::splat_accesses;
pub use stages::{Stages, field_stages, splat_stages};
pub use tables::table_traffic;
pub use traffic::{Traffic, is_volume, traffic};

/// Reads of feature vectors, in rounds.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Accesses {
    /// Number of each vector that was read, round after round.
    pub vectors: Vec<u32>,
    /// Where each round begins.
    pub rounds: Vec<u32>,
    /// Vectors that there are.
    pub stored: u64,
    /// Bytes of a vector.
    pub bytes: u32,
}

/// What an on-chip buffer with oracle replacement lets through to memory.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Memory {
    /// Reads of the buffer.
    pub reads: u64,
    /// Reads that it could not serve.
    pub misses: u64,
    /// Of those, vectors that do not lie behind the one before in memory.
    pub not_streaming: u64,
}

/// What the banks of a feature-major buffer do.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Banks {
    /// Reads.
    pub reads: u64,
    /// Reads that wait for another vector of their bank in their round.
    pub conflicts: u64,
}

impl Memory {
    /// Misses over reads.
    #[must_use]
    pub fn miss_rate(&self) -> f64 {
        ratio(self.misses, self.reads)
    }

    /// Accesses to memory that do not stream, over all of them.
    #[must_use]
    pub fn not_streaming_rate(&self) -> f64 {
        ratio(self.not_streaming, self.misses)
    }
}

impl Banks {
    /// Conflicts over reads.
    #[must_use]
    pub fn conflict_rate(&self) -> f64 {
        ratio(self.conflicts, self.reads)
    }
}

fn ratio(part: u64, whole: u64) -> f64 {
    part as f64 / whole.max(1) as f64
}

impl Accesses {
    /// Bytes of all vectors.
    #[must_use]
    pub fn stored_bytes(&self) -> u64 {
        self.stored * u64::from(self.bytes)
    }

    /// Misses of a buffer of `capacity` bytes that, when it is full, lets go of
    /// the vector whose next read is the farthest (Belady 1966), which no other
    /// replacement beats. A vector that is read next later than all that are
    /// held is not kept.
    #[must_use]
    pub fn memory(&self, capacity: u64) -> Memory {
        let places = (capacity / u64::from(self.bytes.max(1))) as usize;
        let mut next = vec![u32::MAX; self.vectors.len()];
        let mut latest = vec![u32::MAX; self.stored as usize];
        for (i, vector) in self.vectors.iter().enumerate().rev() {
            let last = &mut latest[*vector as usize];
            next[i] = *last;
            *last = i as u32;
        }
        // Held vectors by their next read; when each is read next.
        let mut held: BTreeSet<(u32, u32)> = BTreeSet::new();
        let mut due = vec![None; self.stored as usize];
        let mut memory = Memory {
            reads: self.vectors.len() as u64,
            misses: 0,
            not_streaming: 0,
        };
        let mut before = None;
        for (vector, next) in self.vectors.iter().zip(next) {
            if let Some(at) = due[*vector as usize].take() {
                held.remove(&(at, *vector));
            } else {
                memory.misses += 1;
                let streams = before.is_some_and(|b: u32| b.checked_add(1) == Some(*vector));
                memory.not_streaming += u64::from(!streams);
                before = Some(*vector);
            }
            // Never read again: its place is free.
            if next == u32::MAX {
                continue;
            }
            if held.len() >= places {
                match held.last().copied() {
                    Some((farthest, other)) if farthest > next => {
                        held.remove(&(farthest, other));
                        due[other as usize] = None;
                    }
                    _ => continue,
                }
            }
            held.insert((next, *vector));
            due[*vector as usize] = Some(next);
        }
        memory
    }

    /// Conflicts where vector `v` lies wholly in bank `v mod banks` (the
    /// feature-major layout that the paper argues against) and a bank gives one
    /// vector a round. Lanes that want the same vector share it.
    #[must_use]
    pub fn banks(&self, banks: u32) -> Banks {
        let banks = banks.max(1);
        let mut found = Banks {
            reads: self.vectors.len() as u64,
            conflicts: 0,
        };
        let ends = self.rounds.iter().skip(1).copied();
        let ends = ends.chain([self.vectors.len() as u32]);
        let mut round: Vec<u32> = vec![];
        for (from, to) in self.rounds.iter().zip(ends) {
            round.clear();
            round.extend_from_slice(&self.vectors[*from as usize..to as usize]);
            round.sort_unstable_by_key(|v| (v % banks, *v));
            round.dedup();
            let used = round.chunk_by(|a, b| a % banks == b % banks).count();
            found.conflicts += (round.len() - used) as u64;
        }
        found
    }
}

/// Interleaves the reads of lanes: `lanes` of them side by side, then the next
/// ones.
fn interleave(lists: &[Vec<u32>], lanes: usize, stored: u64, bytes: u32) -> Accesses {
    let mut all = Accesses {
        stored,
        bytes,
        ..Accesses::default()
    };
    for group in lists.chunks(lanes.max(1)) {
        let longest = group.iter().map(Vec::len).max().unwrap_or(0);
        for step in 0..longest {
            all.rounds.push(all.vectors.len() as u32);
            all.vectors
                .extend(group.iter().filter_map(|lane| lane.get(step)));
        }
    }
    all
}

/// A field that stops no ray.
#[cfg(test)]
struct Endless<'a>(&'a dyn Field);

#[cfg(test)]
impl Field for Endless<'_> {
    fn tables(&self) -> &[crate::fields::Table] {
        self.0.tables()
    }
    fn place(&self, at: DVec3, places: &mut [DVec3]) {
        self.0.place(at, places);
    }
    fn holds(&self, at: DVec3) -> bool {
        self.0.holds(at)
    }
    fn depth(&self, _: &[f64]) -> f64 {
        0.0
    }
    fn colour(&self, _: &[f64], _: DVec3, _: &mut Vec<f64>) -> DVec3 {
        DVec3::ZERO
    }
    fn sampling(&self) -> crate::fields::Sampling {
        self.0.sampling()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn one_lane(vectors: &[u32], stored: u64) -> Accesses {
        interleave(&[vectors.to_vec()], 1, stored, 10)
    }

    #[test]
    fn the_oracle_keeps_what_comes_back_first() {
        // Belady's own kind of example: three places.
        let reads = [0, 1, 2, 3, 0, 1, 4, 0, 1, 2, 3, 4];
        assert_eq!(one_lane(&reads, 5).memory(30).misses, 7);
        // Everything fits: each vector misses once.
        let memory = one_lane(&reads, 5).memory(50);
        assert_eq!((memory.misses, memory.reads), (5, 12));
        // 0 to 4 follow one another, but for the first.
        assert_eq!(memory.not_streaming, 1);
        assert_eq!(one_lane(&reads, 5).memory(0).misses, 12);
    }

    #[test]
    fn lanes_share_a_vector_and_wait_for_another_of_its_bank() {
        let lists = [vec![0, 1], vec![16, 1], vec![32, 3], vec![5]];
        let all = interleave(&lists, 4, 40, 2);
        assert_eq!(all.vectors, [0, 16, 32, 5, 1, 1, 3]);
        assert_eq!(all.rounds, [0, 4]);
        let banks = all.banks(16);
        assert_eq!((banks.reads, banks.conflicts), (7, 2));
        assert_eq!(all.banks(64).conflicts, 0);
        assert_eq!(all.banks(1).conflicts, 3 + 1);
    }

    /// The fewest misses by trying every replacement.
    fn fewest(reads: &[u32], held: &BTreeSet<u32>, places: usize) -> u64 {
        let Some((first, rest)) = reads.split_first() else {
            return 0;
        };
        if held.contains(first) {
            return fewest(rest, held, places);
        }
        let mut best = fewest(rest, held, places);
        let mut with = held.clone();
        with.insert(*first);
        if with.len() <= places {
            best = best.min(fewest(rest, &with, places));
        } else {
            for out in held {
                let mut with = with.clone();
                with.remove(out);
                best = best.min(fewest(rest, &with, places));
            }
        }
        best + 1
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(60))]

        #[test]
        fn no_replacement_misses_less(
            reads in prop::collection::vec(0u32..5, 1..11),
            places in 0usize..4,
        ) {
            let found = one_lane(&reads, 5).memory(10 * places as u64).misses;
            prop_assert_eq!(found, fewest(&reads, &BTreeSet::new(), places));
        }
    }
}
