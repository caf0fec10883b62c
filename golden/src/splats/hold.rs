//! Putting gathered records into rank order.

use std::collections::BTreeMap;

use potamoi_formats::record::SplatRecord;

/// In which order gathered records are composited.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum Order {
    /// By rank. Records are held back until every MVoxel to come starts at a
    /// higher rank.
    #[default]
    Exact,
    /// As they arrive.
    Approximate,
}

/// A gathered record and the slot it is for.
pub(crate) type Arrival = (u16, SplatRecord);

/// What holding records back takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct HoldStats {
    /// The most records that were held while the next MVoxel was gathered.
    pub occupancy: u64,
    /// The most (tile, Gaussian) entries of them.
    pub entries: u64,
    /// Records that went to memory and came back because more were held than
    /// fit on chip.
    pub spilled: u64,
}

/// The records held back, by rank.
#[derive(Debug, Default)]
pub(crate) struct Hold {
    records: BTreeMap<u32, Vec<Arrival>>,
    entries: u64,
    capacity: u64,
    excess: u64,
    stats: HoldStats,
}

impl Hold {
    /// `capacity` is how many records fit on chip.
    pub(crate) fn new(capacity: usize) -> Self {
        Self {
            capacity: capacity as u64,
            ..Self::default()
        }
    }

    pub(crate) fn arrive(&mut self, arrival: Arrival) {
        self.records
            .entry(arrival.1.rank)
            .or_default()
            .push(arrival);
        self.entries += 1;
    }

    /// Hands out, by rank, what lies below `next`, the lowest rank of what is
    /// still to come, or all of it for `None`.
    pub(crate) fn retire(&mut self, next: Option<u32>, mut out: impl FnMut(Arrival)) {
        let kept = match next {
            Some(rank) => self.records.split_off(&rank),
            None => BTreeMap::new(),
        };
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
        let excess = held.saturating_sub(self.capacity);
        self.stats.spilled += excess.saturating_sub(self.excess);
        self.excess = excess;
    }

    pub(crate) fn stats(&self) -> HoldStats {
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
                spilled: 2
            }
        );
        hold.arrive(arrival(2, 1));
        hold.retire(Some(7), |(s, r)| out.push((r.rank, s)));
        hold.retire(None, |(s, r)| out.push((r.rank, s)));
        assert_eq!(out, [(0, 0), (2, 1), (5, 0), (5, 3), (7, 0), (9, 0)]);
        assert_eq!(hold.stats().occupancy, 3);
    }
}
