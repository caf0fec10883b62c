//! The reorder buffer, which puts gathered records into rank order.

use std::collections::{BTreeMap, BTreeSet};

use potamoi_formats::record::SplatRecord;

/// The order in which gathered records are composited.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default, serde::Serialize)]
pub enum Order {
    /// By rank. Records are held back until all MVoxels to come start at a higher rank.
    #[default]
    Exact,
    /// In the order of arrival.
    Approximate,
}

/// The slot of a gathered record, and the record.
pub(crate) type Arrival = (u16, SplatRecord);

/// Statistics of the reorder buffer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct HoldStats {
    /// Peak number of records held while the next MVoxel was gathered.
    pub occupancy: u64,
    /// Peak number of (tile, Gaussian) entries of these records.
    pub entries: u64,
    /// Records written to memory and read back because the buffer was full.
    pub spilled: u64,
    /// The (tile, Gaussian) entries of the spilled records.
    pub spilled_entries: u64,
}

impl HoldStats {
    /// The combined statistics of two ray groups, one after the other.
    pub fn and(self, other: Self) -> Self {
        Self {
            occupancy: self.occupancy.max(other.occupancy),
            entries: self.entries.max(other.entries),
            spilled: self.spilled + other.spilled,
            spilled_entries: self.spilled_entries + other.spilled_entries,
        }
    }
}

/// Records held back, by rank.
///
/// The records needed last make room: after an MVoxel has arrived and the records that it releases
/// have left, the highest ranks above the capacity are written to memory with their tiles. They
/// stay there until their turn, so a record is written at most once and read back once.
#[derive(Debug, Default)]
pub struct Hold {
    records: BTreeMap<u32, Vec<Arrival>>,
    entries: u64,
    on_chip: BTreeSet<u32>,
    capacity: usize,
    stats: HoldStats,
}

impl Hold {
    /// An empty buffer. `capacity` is the number of records that fit on chip.
    pub fn new(capacity: usize) -> Self {
        Self {
            capacity,
            ..Self::default()
        }
    }

    /// Accepts an entry whose turn by depth may not have come.
    pub fn arrive(&mut self, arrival: Arrival) {
        let rank = arrival.1.rank;
        let held = self.records.entry(rank).or_default();
        if held.is_empty() {
            self.on_chip.insert(rank);
        }
        held.push(arrival);
        self.entries += 1;
    }

    /// Releases the records below `next` by rank, where `next` is the lowest rank still to come;
    /// with `None` all of them.
    pub fn retire(&mut self, next: Option<u32>, mut out: impl FnMut(Arrival)) {
        let (kept, on_chip) = match next {
            Some(rank) => (self.records.split_off(&rank), self.on_chip.split_off(&rank)),
            None => Default::default(),
        };
        self.on_chip = on_chip;
        for arrival in std::mem::replace(&mut self.records, kept)
            .into_values()
            .flatten()
        {
            self.entries -= 1;
            out(arrival);
        }
        let held = self.records.len() as u64;
        self.stats.occupancy = self.stats.occupancy.max(held);
        self.stats.entries = self.stats.entries.max(self.entries);
        while self.on_chip.len() > self.capacity {
            let Some(last) = self.on_chip.pop_last() else {
                break;
            };
            self.stats.spilled += 1;
            self.stats.spilled_entries += self.records.get(&last).map_or(0, Vec::len) as u64;
        }
    }

    /// Statistics so far.
    #[must_use]
    pub fn stats(&self) -> HoldStats {
        self.stats
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arrival(rank: u32, slot: u16) -> Arrival {
        let record = SplatRecord {
            mean: [0; 2],
            factor: [0; 3],
            opacity: 0,
            colour: [0; 3],
            rank,
        };
        (slot, record)
    }

    #[test]
    fn records_leave_by_rank_and_wait_for_lower_ones() {
        let mut hold = Hold::new(1);
        let mut out = Vec::new();
        for rank in [0, 5, 9, 7] {
            hold.arrive(arrival(rank, 0));
        }
        hold.arrive(arrival(5, 3));
        hold.retire(Some(2), |(s, r)| out.push((r.rank, s)));
        assert_eq!(out, [(0, 0)]);
        assert_eq!(
            hold.stats(),
            HoldStats {
                occupancy: 3,
                entries: 4,
                // 7 and 9 go, 5 with its two tiles stays.
                spilled: 2,
                spilled_entries: 2,
            }
        );
        hold.arrive(arrival(2, 1));
        hold.retire(Some(7), |(s, r)| out.push((r.rank, s)));
        hold.retire(None, |(s, r)| out.push((r.rank, s)));
        assert_eq!(out, [(0, 0), (2, 1), (5, 0), (5, 3), (7, 0), (9, 0)]);
        assert_eq!(hold.stats().occupancy, 3);
    }

    /// Steps of arrivals and the next lowest rank; what has spilled after each.
    fn spilled(capacity: usize, steps: &[(&[u32], Option<u32>, u64)]) {
        let mut hold = Hold::new(capacity);
        for (ranks, next, spilled) in steps {
            for rank in *ranks {
                hold.arrive(arrival(*rank, 0));
            }
            hold.retire(*next, |_| ());
            assert_eq!(hold.stats().spilled, *spilled, "{ranks:?}");
        }
    }

    #[test]
    fn records_spill_once_each_whatever_the_excess_does() {
        // 9 stays in memory while 10 and 11 take the place of 5 and 6.
        let steps: [(&[u32], _, _); 3] = [
            (&[5, 6, 9], Some(5), 1),
            (&[10], Some(9), 1),
            (&[11], Some(9), 1),
        ];
        spilled(2, &steps);
        // One in memory before and after, not the same.
        spilled(1, &[(&[5, 6], Some(5), 1), (&[8, 9], Some(8), 2)]);
        // 7 comes later than 9 and leaves earlier.
        spilled(1, &[(&[9], Some(7), 0), (&[7], Some(7), 1)]);
        // What leaves at once takes no place.
        spilled(0, &[(&[0, 1], Some(2), 0), (&[2, 3], None, 0)]);
        spilled(0, &[(&[0, 4], Some(2), 1), (&[2, 3], None, 1)]);
    }
}
