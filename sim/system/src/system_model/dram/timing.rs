//! Geometry and timing of a memory.

/// Address mapping.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Geometry {
    /// Channels, a power of two; consecutive bursts are interleaved over them.
    pub channels: u32,
    /// Ranks of a channel, a power of two: dies that share its bus.
    pub ranks: u32,
    /// Bank groups of a rank, a power of two; 1 without groups. Consecutive bursts of a channel are
    /// interleaved over them.
    pub bank_groups: u32,
    /// Banks of a rank, a power of two.
    pub banks: u32,
    /// Bursts in a row, a power of two.
    pub row_bursts: u32,
    /// Bytes of a burst.
    pub burst_bytes: u32,
}

impl Geometry {
    /// Maps an address: from the lowest bit up burst, channel, bank group, column, bank, rank, row.
    pub(super) const fn place(self, address: u64) -> BurstAddress {
        let burst = address / self.burst_bytes as u64;
        let (burst, channel) = split(burst, self.channels);
        let (burst, group) = split(burst, self.bank_groups);
        let (burst, column) = split(burst, self.row_bursts);
        let (burst, of_group) = split(burst, self.banks_of_group());
        let (row, rank) = split(burst, self.ranks);
        BurstAddress {
            channel,
            bank: rank * self.banks + group * self.banks_of_group() + of_group,
            row,
            column,
        }
    }

    /// Banks of a bank group.
    #[must_use]
    pub const fn banks_of_group(self) -> u32 {
        self.banks / self.bank_groups
    }

    /// Ranks of all channels.
    #[must_use]
    pub const fn all_ranks(self) -> u32 {
        self.channels * self.ranks
    }
}

const fn split(value: u64, by: u32) -> (u64, u32) {
    (value / by as u64, (value % by as u64) as u32)
}

/// Channel, bank, row and column of a burst.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BurstAddress {
    pub(super) channel: u32,
    /// Bank of the channel: by rank, then group.
    pub(super) bank: u32,
    pub(super) row: u64,
    pub(super) column: u32,
}

/// Delays in clocks of the command bus.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Timing {
    /// Clock period in nanoseconds.
    pub clock_ns: f64,
    /// Read command to data (RL).
    pub read_latency: u64,
    /// Write command to data (WL).
    pub write_latency: u64,
    /// Clocks of a burst's data.
    pub burst: u64,
    /// Activate to read or write (tRCD).
    pub activate_to_column: u64,
    /// Precharge to activate (tRPpb).
    pub precharge: u64,
    /// Activate to precharge (tRAS).
    pub activate_to_precharge: u64,
    /// Activate to activate of another bank of the rank (tRRD).
    pub activate_to_activate: u64,
    /// Window of four activates of a rank (tFAW).
    pub four_activates: u64,
    /// Column command to column command of another bank group (tCCD, tCCD_S).
    pub column_to_column: u64,
    /// The same within a bank group (tCCD_L).
    pub column_to_column_group: u64,
    /// End of write data to read of another bank group (tWTR, tWTR_S).
    pub write_to_read: u64,
    /// The same within a bank group (tWTR_L).
    pub write_to_read_group: u64,
    /// End of write data to precharge (tWR).
    pub write_recovery: u64,
    /// Read to precharge (tRTP).
    pub read_to_precharge: u64,
    /// Precharge to precharge of another bank of the rank (tPPD).
    pub precharge_to_precharge: u64,
    /// Gap of the bus between read and written data of a rank.
    pub turnaround: u64,
    /// Gap of the bus between data of two ranks.
    pub rank_switch: u64,
    /// Refresh of all banks of a rank (tRFCab).
    pub refresh: u64,
    /// Refresh interval of a rank (tREFI).
    pub refresh_interval: u64,
}

/// Where a bank is, seen from the bank of a column command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Relation {
    SameGroup,
    OtherGroup,
    OtherRank,
}

impl Timing {
    /// Clocks from a column command to the next read and the next write command.
    pub(super) fn after_column(&self, is_write: bool, relation: Relation) -> [u64; 2] {
        let (first, second) = match is_write {
            true => (self.write_latency, self.read_latency),
            false => (self.read_latency, self.write_latency),
        };
        let turned = |gap: u64| (first + self.burst + gap).saturating_sub(second);
        let again = match relation {
            Relation::SameGroup => self.column_to_column_group.max(self.burst),
            Relation::OtherGroup => self.column_to_column.max(self.burst),
            // Written data of both comes from the controller.
            Relation::OtherRank if is_write => self.burst,
            Relation::OtherRank => self.burst + self.rank_switch,
        };
        let written = self.write_latency + self.burst;
        match (is_write, relation) {
            (true, Relation::SameGroup) => [written + self.write_to_read_group, again],
            (true, Relation::OtherGroup) => [written + self.write_to_read, again],
            (true, Relation::OtherRank) => [turned(self.rank_switch), again],
            (false, Relation::OtherRank) => [again, turned(self.rank_switch)],
            (false, _) => [again, turned(self.turnaround)],
        }
    }

    pub(super) const fn write_to_precharge(&self) -> u64 {
        self.write_latency + self.burst + self.write_recovery
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const LPDDR3: Geometry = Geometry {
        channels: 4,
        ranks: 1,
        bank_groups: 1,
        banks: 8,
        row_bursts: 128,
        burst_bytes: 32,
    };

    #[test]
    fn every_burst_has_a_place_of_its_own() {
        let geometry = LPDDR3;
        let row = 4 * 4096u64;
        let of = |address| geometry.place(address);
        assert_eq!(of(0), of(31));
        assert_eq!((of(32).channel, of(32).column), (1, 0));
        assert_eq!((of(128).channel, of(128).column), (0, 1));
        assert_eq!((of(row).bank, of(row).row, of(row).column), (1, 0, 0));
        assert_eq!((of(8 * row).bank, of(8 * row).row), (0, 1));
    }

    /// Ranks lie above all banks, and groups below the columns.
    #[test]
    fn ranks_and_groups_have_places_of_their_own() {
        let ranks = Geometry { ranks: 2, ..LPDDR3 };
        let of = |address| ranks.place(address);
        let row = 4 * 4096u64;
        assert_eq!((of(7 * row).bank, of(7 * row).row), (7, 0));
        assert_eq!((of(8 * row).bank, of(8 * row).row), (8, 0));
        assert_eq!((of(16 * row).bank, of(16 * row).row), (0, 1));
        let groups = Geometry {
            bank_groups: 4,
            banks: 16,
            ..LPDDR3
        };
        let of = |burst: u64| groups.place(32 * burst);
        assert_eq!((of(4).bank, of(4).column), (4, 0));
        assert_eq!((of(16).bank, of(16).column), (0, 1));
        assert_eq!((of(16 * 128).bank, of(16 * 128).column), (1, 0));
    }
}
