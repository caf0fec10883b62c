//! Energy of commands and of standing by, from supply currents.

use super::{Counts, Timing};

/// Supply currents of one device in milliamperes, as pairs of VDD1 and VDD2.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Currents {
    /// Volts of VDD1 and VDD2.
    pub volts: [f64; 2],
    /// One bank activated and precharged again and again (IDD0).
    pub activate: [f64; 2],
    /// Nanoseconds that it is open and closed in that measurement (tRAS, tRPpb).
    pub activate_ns: [f64; 2],
    /// All rows closed (IDD2N).
    pub closed: [f64; 2],
    /// A row open (IDD3N).
    pub open: [f64; 2],
    /// Reading without a gap (IDD4R).
    pub read: [f64; 2],
    /// Writing without a gap (IDD4W).
    pub write: [f64; 2],
    /// Refreshing without a gap (IDD5).
    pub refresh: [f64; 2],
}

impl Currents {
    /// 8 Gb x32 at 1600 MT/s, as manufacturers' data sheets have them; outputs' own supply and
    /// the bus are not in it.
    pub const LPDDR3_8GB: Self = Self {
        volts: [1.8, 1.2],
        activate: [8.0, 60.0],
        activate_ns: [42.0, 18.0],
        closed: [0.8, 26.0],
        open: [2.0, 34.0],
        read: [2.0, 230.0],
        write: [2.0, 240.0],
        refresh: [28.0, 150.0],
    };

    /// Picojoules of a current above another for so many nanoseconds: mA V ns.
    fn above(&self, of: [f64; 2], base: [f64; 2], ns: f64) -> f64 {
        let watts = [0, 1].map(|i| (of[i] - base[i]) * self.volts[i]);
        (watts[0] + watts[1]) * ns
    }

    /// Picojoules of a row's opening and closing, standing by not counted.
    #[must_use]
    pub fn activate_pj(&self) -> f64 {
        let [open, closed] = self.activate_ns;
        self.above(self.activate, self.open, open) + self.above(self.activate, self.closed, closed)
    }

    /// Picojoules of a burst that is read.
    #[must_use]
    pub fn read_pj(&self, timing: &Timing) -> f64 {
        self.above(self.read, self.open, timing.burst as f64 * timing.clock_ns)
    }

    /// Picojoules of a burst that is written.
    #[must_use]
    pub fn write_pj(&self, timing: &Timing) -> f64 {
        self.above(self.write, self.open, timing.burst as f64 * timing.clock_ns)
    }

    /// Picojoules of a refresh of all banks, which are closed meanwhile.
    #[must_use]
    pub fn refresh_pj(&self, timing: &Timing) -> f64 {
        let ns = timing.refresh as f64 * timing.clock_ns;
        self.above(self.refresh, self.closed, ns)
    }

    /// Energy of what was done in so many clocks, by `channels` devices.
    #[must_use]
    pub fn energy(&self, done: &Counts, timing: &Timing, channels: u32, clocks: u64) -> Energy {
        let none = [0.0; 2];
        let ns = |clocks: u64| clocks as f64 * timing.clock_ns;
        let all = clocks * u64::from(channels);
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

/// Picojoules by what they were spent on.
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
    /// Standing by.
    pub standby_pj: f64,
}

impl Energy {
    /// All of it, in picojoules.
    #[must_use]
    pub fn total_pj(&self) -> f64 {
        self.access_pj() + self.refresh_pj + self.standby_pj
    }

    /// What accesses alone cost, in picojoules.
    #[must_use]
    pub fn access_pj(&self) -> f64 {
        self.activate_pj + self.read_pj + self.write_pj
    }
}
