//! Memory: time and energy of a sequence of accesses, from ranks, banks, rows and refresh.
//!
//! Each channel has a controller. It serves row hits first and otherwise the oldest access,
//! collects writes until a batch is worth a turnaround, keeps rows open, issues one command a
//! clock, and refreshes its ranks in turn. Accesses come as fast as the controllers accept them.

mod bank;
mod channel;
mod counts;
mod energy;
#[cfg(test)]
mod tests;
mod timing;

pub use counts::Counts;
pub use energy::{Currents, Energy, Interface};
pub use timing::{Geometry, Timing};

use channel::Channel;

/// Hash of what the rules here give for sequences of a test, by which kept results are known. The
/// test has the new one where the rules change.
pub(crate) const RESULTS: &str = "a10694dff73edd0b";

/// Reads that wait in the controllers and the queues of all banks at most.
pub(crate) const fn waiting(geometry: &Geometry) -> usize {
    let banks = (geometry.ranks * geometry.banks) as usize;
    geometry.channels as usize * (channel::HELD + bank::QUEUE * banks)
}

/// One burst.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Access {
    /// Byte address; the burst that contains it is accessed.
    pub address: u64,
    /// Whether it is a write.
    pub is_write: bool,
}

/// A memory with one or more channels.
#[derive(Debug, Clone)]
pub struct Dram {
    geometry: Geometry,
    timing: Timing,
    channels: Vec<Channel>,
}

impl Dram {
    /// A memory with empty queues and closed rows.
    #[must_use]
    pub fn new(geometry: Geometry, timing: Timing) -> Self {
        let channel = Channel::new(&geometry, timing);
        Self {
            geometry,
            timing,
            channels: vec![channel; geometry.channels as usize],
        }
    }

    /// Serves all accesses, each offered as soon as its controller has room and all before it were
    /// accepted.
    pub fn serve(&mut self, accesses: impl IntoIterator<Item = Access>) -> Counts {
        for access in accesses {
            let place = self.geometry.place(access.address);
            let channel = place.channel as usize;
            while !self.channels[channel].has_room(access.is_write) {
                self.channels.iter_mut().for_each(Channel::step);
            }
            self.channels[channel].take(place, access.is_write);
        }
        self.channels.iter_mut().for_each(Channel::finish);
        self.counts()
    }

    /// Counts so far.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.channels
            .iter()
            .fold(Counts::default(), |sum, channel| {
                let own = channel.counts();
                Counts {
                    clocks: sum.clocks.max(own.clocks),
                    active_clocks: sum.active_clocks + own.active_clocks,
                    reads: sum.reads + own.reads,
                    writes: sum.writes + own.writes,
                    activates: sum.activates + own.activates,
                    refreshes: sum.refreshes + own.refreshes,
                }
            })
    }

    /// Clocks in nanoseconds.
    #[must_use]
    pub fn nanoseconds(&self, clocks: u64) -> f64 {
        clocks as f64 * self.timing.clock_ns
    }
}
