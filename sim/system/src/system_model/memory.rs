//! Time and energy of a byte by access pattern, measured by running [`dram`](super::dram) on
//! sequences of that pattern. No rate is stated by hand.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use potamoi_base::content_hash::hash_of;
use potamoi_result_cache::{self as result_cache, Key};
use rand::{Rng, SeedableRng};
use rand_pcg::Pcg64Mcg;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::dram::{self, Access, Counts, Currents, Dram, Geometry, Interface, Timing};
use super::memory_device::MemoryDevice;
use super::system::System;

/// Bursts of a measured sequence; more hardly change the rates.
const BURSTS: u64 = 20_000;
/// Random runs begin at addresses below this: 1 GB.
const SPAN: u64 = 1 << 30;

/// Time, energy and rows opened, each for a byte.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Rate {
    /// Nanoseconds.
    pub ns: f64,
    /// Picojoules above standby, refreshes excluded, data lines included.
    pub pj: f64,
    /// The part of the data lines.
    pub io_pj: f64,
    /// Rows opened.
    pub rows: f64,
}

impl Rate {
    /// The rate for a byte requested, where so many are moved for it.
    #[must_use]
    pub(super) fn over(self, moved: f64) -> Self {
        Self {
            ns: self.ns * moved,
            pj: self.pj * moved,
            io_pj: self.io_pj * moved,
            rows: self.rows * moved,
        }
    }

    /// So much of this rate, and the rest of another.
    #[must_use]
    pub(super) fn mixed(self, share: f64, other: Self) -> Self {
        let mix = |of: fn(&Self) -> f64| share * of(&self) + (1.0 - share) * of(&other);
        Self {
            ns: mix(|rate| rate.ns),
            pj: mix(|rate| rate.pj),
            io_pj: mix(|rate| rate.io_pj),
            rows: mix(|rate| rate.rows),
        }
    }
}

/// The memory of a system.
#[derive(Debug)]
pub struct Memory {
    geometry: Geometry,
    timing: Timing,
    currents: Currents,
    interface: Interface,
    /// Rates that were measured.
    rates: Mutex<BTreeMap<Pattern, Rate>>,
    /// Folder of rates that earlier runs measured.
    folder: Option<PathBuf>,
}

/// An access pattern whose rate is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
enum Pattern {
    /// Sequential reads.
    Read,
    /// Sequential writes.
    Write,
    /// Random reads of so many bursts each.
    Random(u64),
}

impl Memory {
    /// So many channels of a device.
    #[must_use]
    pub fn new(device: &MemoryDevice, channels: u32) -> Self {
        Self {
            geometry: device.geometry(channels),
            timing: device.timing(),
            currents: device.currents(),
            interface: device.interface(),
            rates: Mutex::default(),
            folder: None,
        }
    }

    /// Keeps rates between runs in files of `folder`, which is created if missing.
    #[must_use]
    pub fn kept_in(self, folder: &Path) -> Self {
        Self {
            folder: Some(folder.to_owned()),
            ..self
        }
    }

    /// The memory of a system.
    #[must_use]
    pub fn of(system: &System) -> Self {
        Self::new(&system.memory, system.memory_channels)
    }

    /// The default device, with so many channels.
    #[must_use]
    pub fn with_channels(channels: u32) -> Self {
        Self::new(&MemoryDevice::default(), channels)
    }

    pub(super) fn measured(&self, accesses: impl Iterator<Item = Access>) -> Rate {
        let mut dram = Dram::new(self.geometry, self.timing);
        let done = dram.serve(accesses);
        let bytes = ((done.reads + done.writes) * u64::from(self.geometry.burst_bytes)) as f64;
        let energy =
            self.currents
                .energy(&done, &self.timing, self.geometry.all_ranks(), done.clocks);
        let io_pj = 8.0 * self.interface.pj_a_bit();
        Rate {
            ns: dram.nanoseconds(done.clocks) / bytes,
            pj: energy.access_pj() / bytes + io_pj,
            io_pj,
            rows: done.activates as f64 / bytes,
        }
    }

    /// Hash of all that decides the rates: parameters, and the rules of [`dram`].
    #[must_use]
    pub fn identity(&self) -> blake3::Hash {
        let Self {
            geometry,
            timing,
            currents,
            interface,
            // Found of the others.
            rates: _,
            folder: _,
        } = self;
        hash_of(&(dram::RESULTS, geometry, timing, currents, interface))
    }

    /// Channels.
    #[must_use]
    pub const fn channels(&self) -> u32 {
        self.geometry.channels
    }

    /// Bursts that wait in all queues at most.
    #[must_use]
    pub const fn waiting(&self) -> usize {
        dram::waiting(&self.geometry)
    }

    /// Bytes of a burst, the least that is moved.
    #[must_use]
    pub const fn burst_bytes(&self) -> u64 {
        self.geometry.burst_bytes as u64
    }

    /// Rate of sequential reads.
    #[must_use]
    pub fn streamed(&self) -> Rate {
        self.rate(Pattern::Read)
    }

    /// Rate of sequential writes.
    #[must_use]
    pub fn written(&self) -> Rate {
        self.rate(Pattern::Write)
    }

    /// Rate of random reads of `run_bytes` each, for a byte requested. Bursts are whole, so bytes
    /// moved beyond the request are in its time and energy.
    #[must_use]
    pub fn random(&self, run_bytes: f64) -> Rate {
        let burst = self.burst_bytes() as f64;
        let bursts = ((run_bytes / burst).ceil() as u64).clamp(1, 4096);
        let of_bursts = self.rate(Pattern::Random(bursts));
        of_bursts.over(self.moved(run_bytes))
    }

    fn rate(&self, pattern: Pattern) -> Rate {
        // A lock is held by nobody who fails.
        let mut known = self.rates.lock().unwrap_or_else(|e| e.into_inner());
        *known.entry(pattern).or_insert_with(|| self.kept(pattern))
    }

    /// A rate as an earlier run measured it, or else measured now.
    fn kept(&self, pattern: Pattern) -> Rate {
        let Some(folder) = &self.folder else {
            return self.of_pattern(pattern);
        };
        let file = self.key(pattern).file(folder, "json");
        result_cache::read(&file).unwrap_or_else(|| {
            let rate = self.of_pattern(pattern);
            // Counts are kept in the same folder, and say so where it cannot be written.
            let written = std::fs::create_dir_all(folder);
            let _ = written.and_then(|()| result_cache::write(&file, &rate));
            rate
        })
    }

    fn key(&self, pattern: Pattern) -> Key {
        Key::new("rate", "1")
            .hash("memory", self.identity())
            .value("pattern", &pattern)
            .value("sequence", &(BURSTS, SPAN))
    }

    fn of_pattern(&self, pattern: Pattern) -> Rate {
        let burst = self.burst_bytes();
        let all = BURSTS * u64::from(self.geometry.channels);
        let stream = |is_write| {
            (0..all).map(move |i| Access {
                address: i * burst,
                is_write,
            })
        };
        match pattern {
            Pattern::Read => self.measured(stream(false)),
            Pattern::Write => self.measured(stream(true)),
            Pattern::Random(bursts) => {
                let mut generator = Pcg64Mcg::seed_from_u64(bursts);
                let starts: Vec<u64> = (0..all.div_ceil(bursts))
                    .map(|_| generator.random_range(0..SPAN / burst))
                    .collect();
                self.measured(starts.into_iter().flat_map(|first| {
                    (0..bursts).map(move |i| Access {
                        address: (first + i) * burst,
                        is_write: false,
                    })
                }))
            }
        }
    }

    /// Bytes moved for each byte requested by random reads of `run_bytes`, since bursts are whole.
    #[must_use]
    pub fn moved(&self, run_bytes: f64) -> f64 {
        let burst = f64::from(self.geometry.burst_bytes);
        let bursts = (run_bytes / burst).ceil().max(1.0);
        (bursts * burst / run_bytes.max(1.0)).max(1.0)
    }

    /// Refreshes of all ranks in `ns` nanoseconds.
    #[must_use]
    pub fn refreshes(&self, ns: f64) -> u64 {
        let each = self.timing.refresh_interval as f64 * self.timing.clock_ns;
        (ns / each) as u64 * u64::from(self.geometry.all_ranks())
    }

    /// Milliwatts of all ranks in standby and refresh, with rows open for a share of the time.
    #[must_use]
    pub(crate) fn standby_mw(&self, open: f64) -> f64 {
        let clocks = 1_000_000;
        let ranks = self.geometry.all_ranks();
        let refreshes = clocks / self.timing.refresh_interval * u64::from(ranks);
        let done = Counts {
            clocks,
            active_clocks: (open * (clocks * u64::from(ranks)) as f64) as u64,
            refreshes,
            ..Counts::default()
        };
        let energy = self.currents.energy(&done, &self.timing, ranks, clocks);
        let ns = clocks as f64 * self.timing.clock_ns;
        energy.total_pj() / ns
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn files(folder: &Path) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(folder).unwrap();
        entries.map(|entry| entry.unwrap().path()).collect()
    }

    /// What is kept is what is measured; an edited file is measured again.
    #[test]
    fn rates_are_kept_by_pattern_and_believed_unedited() {
        let folder = tempfile::tempdir().unwrap();
        let kept = || Memory::with_channels(1).kept_in(folder.path());
        let measured = Memory::with_channels(1);
        let of = |own: &Memory| [own.streamed(), own.written(), own.random(64.0)];
        assert_eq!(of(&kept()), of(&measured));
        assert_eq!(files(folder.path()).len(), 3);
        // A rate that no device has, under a sound checksum, shows that files are read.
        let file = kept().key(Pattern::Read).file(folder.path(), "json");
        let other = Rate {
            ns: 7.0,
            ..Rate::default()
        };
        result_cache::write(&file, &other).unwrap();
        assert_eq!(kept().streamed(), other);
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::write(&file, text.replace("7.0", "8.0")).unwrap();
        assert_eq!(kept().streamed(), measured.streamed());
        assert_eq!(of(&kept()), of(&measured));
    }

    #[test]
    fn another_memory_has_other_files() {
        let key = |own: &Memory, pattern| own.key(pattern).hex();
        let mut keys: Vec<_> = MemoryDevice::names()
            .into_iter()
            .flat_map(|name| {
                let device = MemoryDevice::builtin(name).unwrap();
                [1, 2].map(|channels| key(&Memory::new(&device, channels), Pattern::Read))
            })
            .collect();
        let own = Memory::with_channels(1);
        keys.extend([1, 2].map(|bursts| key(&own, Pattern::Random(bursts))));
        keys.push(key(&own, Pattern::Write));
        let count = keys.len();
        keys.sort();
        keys.dedup();
        assert_eq!(keys.len(), count);
    }
}
