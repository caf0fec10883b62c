//! Geometry and timing of LPDDR3 (JEDEC JESD209-3C, 8 Gb x32 at 1600 MT/s).

/// Address mapping.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Geometry {
    /// Channels, a power of two; consecutive bursts are interleaved over them.
    pub channels: u32,
    /// Banks of a channel, a power of two.
    pub banks: u32,
    /// Bursts in a row, a power of two.
    pub row_bursts: u32,
    /// Bytes of a burst: eight transfers of the bus.
    pub burst_bytes: u32,
}

impl Geometry {
    /// Channels of 32 bits with one rank of 8 Gb each: eight banks, rows of 4 KB.
    #[must_use]
    pub const fn lpddr3(channels: u32) -> Self {
        Self {
            channels,
            banks: 8,
            row_bursts: 128,
            burst_bytes: 32,
        }
    }

    /// Maps an address: from the lowest bit up burst, channel, column, bank, row.
    pub(super) const fn place(self, address: u64) -> BurstAddress {
        let burst = address / self.burst_bytes as u64;
        let (burst, channel) = split(burst, self.channels);
        let (burst, column) = split(burst, self.row_bursts);
        let (row, bank) = split(burst, self.banks);
        BurstAddress {
            channel,
            bank,
            row,
            column,
        }
    }
}

const fn split(value: u64, by: u32) -> (u64, u32) {
    (value / by as u64, (value % by as u64) as u32)
}

/// Channel, bank, row and column of a burst.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct BurstAddress {
    pub(super) channel: u32,
    pub(super) bank: u32,
    pub(super) row: u64,
    pub(super) column: u32,
}

/// Delays in clocks of the bus; the clock is half of the transfer rate.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Timing {
    /// Clock period in nanoseconds.
    pub clock_ns: f64,
    /// Read command to data (RL).
    pub read_latency: u64,
    /// Write command to data (WL).
    pub write_latency: u64,
    /// Clocks of a burst's data (BL / 2).
    pub burst: u64,
    /// Activate to read or write (tRCD).
    pub activate_to_column: u64,
    /// Precharge to activate (tRPpb).
    pub precharge: u64,
    /// Activate to precharge (tRAS).
    pub activate_to_precharge: u64,
    /// Activate to activate of another bank (tRRD).
    pub activate_to_activate: u64,
    /// Window of four activates (tFAW).
    pub four_activates: u64,
    /// Column command to column command (tCCD).
    pub column_to_column: u64,
    /// End of write data to read (tWTR).
    pub write_to_read: u64,
    /// End of write data to precharge (tWR).
    pub write_recovery: u64,
    /// Read to precharge (tRTP).
    pub read_to_precharge: u64,
    /// Bus turnaround between data of opposite directions.
    pub turnaround: u64,
    /// Refresh of all banks (tRFCab).
    pub refresh: u64,
    /// Refresh interval (tREFI).
    pub refresh_interval: u64,
}

impl Timing {
    /// 1600 MT/s, 8 Gb, at up to 85 degrees Celsius.
    pub const LPDDR3_1600: Self = Self {
        clock_ns: 1.25,
        read_latency: 12,
        write_latency: 9,
        burst: 4,
        activate_to_column: 15,
        precharge: 15,
        activate_to_precharge: 34,
        activate_to_activate: 8,
        four_activates: 40,
        column_to_column: 4,
        write_to_read: 6,
        write_recovery: 12,
        read_to_precharge: 6,
        turnaround: 1,
        refresh: 168,
        refresh_interval: 3120,
    };

    pub(super) const fn read_to_write(&self) -> u64 {
        self.read_latency + self.burst + self.turnaround - self.write_latency
    }

    pub(super) const fn write_to_read_command(&self) -> u64 {
        self.write_latency + self.burst + self.write_to_read
    }

    pub(super) const fn write_to_precharge(&self) -> u64 {
        self.write_latency + self.burst + self.write_recovery
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_burst_has_a_place_of_its_own() {
        let geometry = Geometry::lpddr3(4);
        let row = 4 * 4096u64;
        let of = |address| geometry.place(address);
        assert_eq!(of(0), of(31));
        assert_eq!((of(32).channel, of(32).column), (1, 0));
        assert_eq!((of(128).channel, of(128).column), (0, 1));
        assert_eq!((of(row).bank, of(row).row, of(row).column), (1, 0, 0));
        assert_eq!((of(8 * row).bank, of(8 * row).row), (0, 1));
    }
}
