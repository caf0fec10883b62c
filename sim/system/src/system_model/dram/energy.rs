//! Energy of commands and of standby, from supply currents.

use super::{Counts, Timing};

/// Supply currents of one rank in milliamperes, as pairs of VDD1 and VDD2, without the outputs' own
/// supply.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Currents {
    /// Volts of VDD1 and VDD2.
    pub volts: [f64; 2],
    /// One bank activated and precharged repeatedly (IDD0).
    pub activate: [f64; 2],
    /// Nanoseconds that the row is open and closed in that measurement (tRAS, tRPpb).
    pub activate_ns: [f64; 2],
    /// All rows closed (IDD2N).
    pub closed: [f64; 2],
    /// A row open (IDD3N).
    pub open: [f64; 2],
    /// Continuous reads (IDD4R).
    pub read: [f64; 2],
    /// Continuous writes (IDD4W).
    pub write: [f64; 2],
    /// Continuous refresh (IDD5).
    pub refresh: [f64; 2],
}

impl Currents {
    /// Picojoules that current `of` takes above `base` in so many nanoseconds: mA V ns.
    fn above(&self, of: [f64; 2], base: [f64; 2], ns: f64) -> f64 {
        let watts = [0, 1].map(|i| (of[i] - base[i]) * self.volts[i]);
        (watts[0] + watts[1]) * ns
    }

    /// Picojoules of opening and closing a row, above standby.
    #[must_use]
    pub(crate) fn activate_pj(&self) -> f64 {
        let [open, closed] = self.activate_ns;
        self.above(self.activate, self.open, open) + self.above(self.activate, self.closed, closed)
    }

    /// Picojoules of a burst read.
    #[must_use]
    pub fn read_pj(&self, timing: &Timing) -> f64 {
        self.above(self.read, self.open, timing.burst as f64 * timing.clock_ns)
    }

    /// Picojoules of a burst written.
    #[must_use]
    pub fn write_pj(&self, timing: &Timing) -> f64 {
        self.above(self.write, self.open, timing.burst as f64 * timing.clock_ns)
    }

    /// Picojoules of a refresh of all banks, which are closed meanwhile.
    #[must_use]
    pub(crate) fn refresh_pj(&self, timing: &Timing) -> f64 {
        let ns = timing.refresh as f64 * timing.clock_ns;
        self.above(self.refresh, self.closed, ns)
    }

    /// Energy of the commands in `done` and of standby over so many clocks, for `ranks` of all
    /// channels.
    #[must_use]
    pub fn energy(&self, done: &Counts, timing: &Timing, ranks: u32, clocks: u64) -> Energy {
        let none = [0.0; 2];
        let ns = |clocks: u64| clocks as f64 * timing.clock_ns;
        let all = clocks * u64::from(ranks);
        let closed = all.saturating_sub(done.active_clocks);
        Energy {
            activate_pj: done.activates as f64 * self.activate_pj(),
            read_pj: done.reads as f64 * self.read_pj(timing),
            write_pj: done.writes as f64 * self.write_pj(timing),
            refresh_pj: done.refreshes as f64 * self.refresh_pj(timing),
            standby_pj: self.above(self.open, none, ns(done.active_clocks))
                + self.above(self.closed, none, ns(closed)),
        }
    }
}

/// Energy by part, in picojoules.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Energy {
    /// Opening and closing rows.
    pub activate_pj: f64,
    /// Bursts read.
    pub read_pj: f64,
    /// Bursts written.
    pub write_pj: f64,
    /// Refreshes.
    pub refresh_pj: f64,
    /// Standby.
    pub standby_pj: f64,
}

impl Energy {
    /// Total energy in picojoules.
    #[must_use]
    pub(crate) fn total_pj(&self) -> f64 {
        self.access_pj() + self.refresh_pj + self.standby_pj
    }

    /// Energy of accesses in picojoules, without refreshes and standby.
    #[must_use]
    pub(crate) fn access_pj(&self) -> f64 {
        self.activate_pj + self.read_pj + self.write_pj
    }
}

/// A data line between the memory and its controller, driven from its own supply.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Interface {
    /// Volts of the supply (VDDQ).
    pub volts: f64,
    /// Volts between the levels of the line.
    pub swing_volts: f64,
    /// Capacitance of driver, line and receivers.
    pub picofarads: f64,
    /// Share of bits that differ from the one before.
    pub changes: f64,
    /// Termination to ground; 0 without.
    pub ohms: f64,
    /// Nanoseconds of a bit.
    pub bit_ns: f64,
}

impl Interface {
    /// Picojoules of a transferred bit: a rise takes its charge from the supply, and a line that is
    /// held high, half of the time, the current of its termination. Strobes are left out.
    #[must_use]
    pub fn pj_a_bit(&self) -> f64 {
        let charged = self.changes / 2.0 * self.picofarads * self.swing_volts * self.volts;
        let held_watts = match self.ohms > 0.0 {
            true => self.swing_volts / self.ohms * self.volts / 2.0,
            false => 0.0,
        };
        // Watts times nanoseconds are nanojoules.
        charged + 1e3 * held_watts * self.bit_ns
    }
}
