//! A buffer with oracle replacement, in one pass over the reads.
//!
//! Keeping a vector from one read to its next occupies its bytes during that time. Reads are
//! processed in order. A read hits if those bytes have been free since the vector's previous read,
//! after the hits before it. For vectors of one size, this keeps the same vectors as evicting the
//! one whose next read is farthest (Belady 1966), which no replacement beats. Later reads are
//! never needed, so no list of reads is stored (Jain and Lin, ISCA 2016, decide the same way).

/// Marks a vector that has not been read.
const NEVER: u32 = u32::MAX;
/// Number of slots before the first clearing, beyond one a vector.
const SLACK: usize = 1 << 20;

/// The buffer.
pub(super) struct Oracle {
    /// Bytes that have been free since each slot. A slot is a read after which something was
    /// evicted. The bytes of the first slot have never been used.
    free: Vec<u32>,
    /// For each slot, a slot at or before it that may have free bytes; itself if it has.
    link: Vec<u32>,
    /// For each vector, the last slot at the time of its last read.
    last: Vec<u32>,
    /// Number of slots at which those without free bytes are removed.
    limit: usize,
    slack: usize,
}

impl Oracle {
    /// An empty buffer of `capacity` bytes for `vectors` vectors.
    pub(super) fn new(capacity: u32, vectors: usize) -> Self {
        Self {
            free: vec![capacity],
            link: vec![0],
            last: vec![NEVER; vectors],
            limit: vectors + SLACK,
            slack: SLACK,
        }
    }

    /// Reads a vector; returns whether it hits.
    pub(super) fn read(&mut self, vector: u32, bytes: u32) -> bool {
        let before = self.last[vector as usize];
        let hit = before != NEVER && self.take(before, bytes);
        if hit {
            if self.free.len() >= self.limit {
                self.clear();
            }
            self.link.push(self.free.len() as u32);
            self.free.push(bytes);
        }
        self.last[vector as usize] = self.free.len() as u32 - 1;
        hit
    }

    /// The last slot up to `slot` that has free bytes, or the first of all.
    fn find(&mut self, mut slot: u32) -> u32 {
        while self.link[slot as usize] != slot {
            let next = self.link[slot as usize];
            self.link[slot as usize] = self.link[next as usize];
            slot = next;
        }
        slot
    }

    /// Takes bytes that have been free since a slot, the most recently freed first.
    fn take(&mut self, since: u32, bytes: u32) -> bool {
        let mut at = self.find(since);
        let (mut slot, mut found) = (at, self.free[at as usize]);
        while found < bytes {
            if slot == 0 {
                return false;
            }
            slot = self.find(slot - 1);
            found = found.saturating_add(self.free[slot as usize]);
        }
        let mut missing = bytes;
        loop {
            let own = &mut self.free[at as usize];
            let part = missing.min(*own);
            *own -= part;
            missing -= part;
            if *own == 0 && at > 0 {
                self.link[at as usize] = at - 1;
            }
            if missing == 0 {
                return true;
            }
            at = self.find(at - 1);
        }
    }

    /// Renumbers the slots with free bytes and removes the others.
    fn clear(&mut self) {
        for vector in 0..self.last.len() {
            if self.last[vector] != NEVER {
                self.last[vector] = self.find(self.last[vector]);
            }
        }
        let mut numbers = vec![0u32; self.free.len()];
        let mut kept = vec![];
        for (number, free) in numbers.iter_mut().zip(&self.free) {
            if *free > 0 || kept.is_empty() {
                *number = kept.len() as u32;
                kept.push(*free);
            }
        }
        for last in self.last.iter_mut().filter(|last| **last != NEVER) {
            *last = numbers[*last as usize];
        }
        self.limit = 2 * kept.len() + self.last.len() + self.slack;
        self.link = (0..kept.len() as u32).collect();
        self.free = kept;
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use proptest::prelude::*;

    use super::*;

    /// Which reads a buffer holds, with few slots between clearings.
    fn hits(reads: &[u32], bytes: impl Fn(u32) -> u32, capacity: u32) -> Vec<bool> {
        let mut oracle = Oracle::new(capacity, 64);
        (oracle.limit, oracle.slack) = (3, 3);
        let read = |v: &u32| oracle.read(*v, bytes(*v));
        reads.iter().map(read).collect()
    }

    fn misses(reads: &[u32], places: u32) -> usize {
        let hits = hits(reads, |_| 10, 10 * places);
        hits.iter().filter(|hit| !**hit).count()
    }

    #[test]
    fn the_oracle_keeps_what_comes_back_first() {
        // Belady's own kind of example: three places.
        let reads = [0, 1, 2, 3, 0, 1, 4, 0, 1, 2, 3, 4];
        assert_eq!(misses(&reads, 3), 7);
        // Everything fits: each vector misses once.
        assert_eq!(misses(&reads, 5), 5);
        assert_eq!(misses(&reads, 0), 12);
        assert_eq!(hits(&[7, 7], |_| 11, 10), [false, false]);
    }

    /// By hand: of 30 bytes, the second read of 0 takes 20 since the first; the
    /// second of 1 finds 10 free for as long, not the 20 that it needs, and that
    /// of 2 takes those.
    #[test]
    fn vectors_of_different_sizes_take_their_bytes() {
        let bytes = |v| [20, 20, 10][v as usize];
        let found = hits(&[0, 1, 2, 0, 1, 2], bytes, 30);
        assert_eq!(found, [false, false, false, true, false, true]);
        let found = hits(&[0, 1, 2, 0, 1, 2], bytes, 50);
        assert_eq!(found, [false, false, false, true, true, true]);
    }

    /// The fewest misses by trying every replacement.
    fn fewest(reads: &[u32], held: &BTreeSet<u32>, places: usize) -> usize {
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

    /// Belady's replacement as it is usually told: when the buffer is full, the
    /// vector whose next read is the farthest goes.
    fn belady(reads: &[u32], places: usize) -> Vec<bool> {
        let next = |from: usize, v: u32| {
            let ahead = reads[from..].iter().position(|r| *r == v);
            ahead.unwrap_or(usize::MAX)
        };
        let mut held: Vec<u32> = vec![];
        let mut all = vec![];
        for (i, read) in reads.iter().enumerate() {
            all.push(held.contains(read));
            if !held.contains(read) {
                held.push(*read);
            }
            if held.len() > places
                && let Some(out) = (0..held.len()).max_by_key(|k| next(i + 1, held[*k]))
            {
                held.remove(out);
            }
        }
        all
    }

    /// Whether bytes are free over all the time between two reads, looked up
    /// moment for moment.
    fn by_moments(reads: &[u32], bytes: impl Fn(u32) -> u32, capacity: u32) -> Vec<bool> {
        let mut used = vec![0u32; reads.len()];
        let mut all = vec![];
        for (i, read) in reads.iter().enumerate() {
            let before = reads[..i].iter().rposition(|r| r == read);
            let hit = before.is_some_and(|from| {
                let fits = used[from..i].iter().all(|u| u + bytes(*read) <= capacity);
                if fits {
                    used[from..i].iter_mut().for_each(|u| *u += bytes(*read));
                }
                fits
            });
            all.push(hit);
        }
        all
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        #[test]
        fn no_replacement_misses_less(
            reads in prop::collection::vec(0u32..5, 1..11),
            places in 0usize..4,
        ) {
            let found = misses(&reads, places as u32);
            prop_assert_eq!(found, fewest(&reads, &BTreeSet::new(), places));
        }

        #[test]
        fn the_same_reads_miss_as_belady_lets_miss(
            reads in prop::collection::vec(0u32..40, 1..400),
            places in 0usize..30,
        ) {
            let found = hits(&reads, |_| 4, 4 * places as u32);
            prop_assert_eq!(found, belady(&reads, places));
        }

        #[test]
        fn bytes_are_free_moment_for_moment(
            reads in prop::collection::vec(0u32..40, 1..400),
            capacity in 0u32..200,
        ) {
            let bytes = |v: u32| 2 + 3 * (v % 7);
            let found = hits(&reads, bytes, capacity);
            prop_assert_eq!(found, by_moments(&reads, bytes, capacity));
        }
    }
}
