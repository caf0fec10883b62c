//! Time and energy of a byte by access pattern, measured by running [`dram`](super::dram) on
//! sequences of that pattern. No rate is stated by hand.

use std::collections::BTreeMap;
use std::sync::Mutex;

use potamoi_base::content_hash::hash_of;
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use serde::{Deserialize, Serialize};

use super::dram::{Access, Counts, Currents, Dram, Geometry, Timing};

/// Bursts of a measured sequence; more hardly change the rates.
const BURSTS: u64 = 20_000;
/// Random runs begin at addresses below this: 1 GB.
const SPAN: u64 = 1 << 30;

/// Time, energy and rows opened, each for a byte.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize)]
pub struct Rate {
    /// Nanoseconds.
    pub ns: f64,
    /// Picojoules above standby, refreshes excluded.
    pub pj: f64,
    /// Rows opened.
    pub rows: f64,
}

/// The memory of a system.
#[derive(Debug)]
pub struct Memory {
    geometry: Geometry,
    timing: Timing,
    currents: Currents,
    read: Rate,
    write: Rate,
    /// Rates of random reads, by bursts in a run.
    random: Mutex<BTreeMap<u64, Rate>>,
}

impl Memory {
    /// LPDDR3-1600 with so many channels.
    #[must_use]
    pub fn lpddr3(channels: u32) -> Self {
        let mut own = Self {
            geometry: Geometry::lpddr3(channels),
            timing: Timing::LPDDR3_1600,
            currents: Currents::LPDDR3_8GB,
            read: Rate::default(),
            write: Rate::default(),
            random: Mutex::default(),
        };
        let burst = u64::from(own.geometry.burst_bytes);
        let stream = |is_write| {
            (0..BURSTS * u64::from(channels)).map(move |i| Access {
                address: i * burst,
                is_write,
            })
        };
        own.read = own.measured(stream(false));
        own.write = own.measured(stream(true));
        own
    }

    pub(super) fn measured(&self, accesses: impl Iterator<Item = Access>) -> Rate {
        let mut dram = Dram::new(self.geometry, self.timing);
        let done = dram.serve(accesses);
        let bytes = ((done.reads + done.writes) * u64::from(self.geometry.burst_bytes)) as f64;
        let energy = self
            .currents
            .energy(&done, &self.timing, self.geometry.channels, done.clocks);
        Rate {
            ns: dram.nanoseconds(done.clocks) / bytes,
            pj: energy.access_pj() / bytes,
            rows: done.activates as f64 / bytes,
        }
    }

    /// Hash of all parameters that decide the rates.
    #[must_use]
    pub fn identity(&self) -> blake3::Hash {
        let Self {
            geometry,
            timing,
            currents,
            // Found of the others.
            read: _,
            write: _,
            random: _,
        } = self;
        hash_of(&(geometry, timing, currents))
    }

    /// Channels.
    #[must_use]
    pub const fn channels(&self) -> u32 {
        self.geometry.channels
    }

    /// Rate of sequential reads.
    #[must_use]
    pub const fn streamed(&self) -> Rate {
        self.read
    }

    /// Rate of sequential writes.
    #[must_use]
    pub const fn written(&self) -> Rate {
        self.write
    }

    /// Rate of random reads of `run_bytes` each, for a byte requested. Bursts are whole, so bytes
    /// moved beyond the request are in its time and energy.
    #[must_use]
    pub fn random(&self, run_bytes: f64) -> Rate {
        let burst = u64::from(self.geometry.burst_bytes);
        let bursts = ((run_bytes / burst as f64).ceil() as u64).clamp(1, 4096);
        // A lock is held by nobody who fails.
        let mut known = self.random.lock().unwrap_or_else(|e| e.into_inner());
        let of_bursts = *known.entry(bursts).or_insert_with(|| {
            let mut generator = Pcg64Mcg::seed_from_u64(bursts);
            let runs = (BURSTS * u64::from(self.geometry.channels)).div_ceil(bursts);
            let starts: Vec<u64> = (0..runs)
                .map(|_| generator.random_range(0..SPAN / burst))
                .collect();
            let all = starts.into_iter().flat_map(|first| {
                (0..bursts).map(move |i| Access {
                    address: (first + i) * burst,
                    is_write: false,
                })
            });
            self.measured(all)
        });
        let over = self.moved(run_bytes);
        Rate {
            ns: of_bursts.ns * over,
            pj: of_bursts.pj * over,
            rows: of_bursts.rows * over,
        }
    }

    /// Bytes moved for each byte requested by random reads of `run_bytes`, since bursts are whole.
    #[must_use]
    pub fn moved(&self, run_bytes: f64) -> f64 {
        let burst = f64::from(self.geometry.burst_bytes);
        let bursts = (run_bytes / burst).ceil().max(1.0);
        (bursts * burst / run_bytes.max(1.0)).max(1.0)
    }

    /// Refreshes of all channels in `ns` nanoseconds.
    #[must_use]
    pub fn refreshes(&self, ns: f64) -> u64 {
        let each = self.timing.refresh_interval as f64 * self.timing.clock_ns;
        (ns / each) as u64 * u64::from(self.geometry.channels)
    }

    /// Milliwatts of all channels in standby and refresh, with rows open for a share of the time.
    #[must_use]
    pub(crate) fn standby_mw(&self, open: f64) -> f64 {
        let clocks = 1_000_000;
        let channels = self.geometry.channels;
        let refreshes = clocks / self.timing.refresh_interval * u64::from(channels);
        let done = Counts {
            clocks,
            active_clocks: (open * (clocks * u64::from(channels)) as f64) as u64,
            refreshes,
            ..Counts::default()
        };
        let energy = self.currents.energy(&done, &self.timing, channels, clocks);
        let ns = clocks as f64 * self.timing.clock_ns;
        energy.total_pj() / ns
    }
}
