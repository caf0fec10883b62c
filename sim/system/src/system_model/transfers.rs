//! Memory transfers of jobs: bytes by access pattern, and their time on memory and the
//! interconnect.

use super::kernels;
use super::memory::{Memory, Rate};
use super::variant::Gathering;
use super::work::{FrameWork, PathReplay, Replayed};
use potamoi_cycles::batch::Batch;

/// Memory transfers of a job.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Transfers {
    pub(super) read: f64,
    pub(super) written: f64,
    pub(super) random: f64,
    /// Bytes of a random access.
    pub(super) run: f64,
    /// Rates of its sequential and of its random reads, where their sequence was replayed.
    pub(super) known: [Option<Replayed>; 2],
    /// Transfers by the DMA.
    pub(super) dma_transfers: u64,
}

impl Transfers {
    pub(super) const fn bytes(&self) -> f64 {
        self.read + self.written + self.random
    }

    /// Bytes over the interconnect.
    pub(super) fn wired(&self, memory: &Memory) -> f64 {
        let [read, random] = self.known;
        self.read * read.map_or(1.0, |own| own.moved)
            + self.written
            + self.random * random.map_or_else(|| memory.moved(self.run), |own| own.moved)
    }

    /// Rates of sequential and of random reads.
    fn rates(&self, memory: &Memory) -> [Rate; 2] {
        let [read, random] = self.known;
        [
            read.map_or_else(|| memory.streamed(), |own| own.replayed),
            random.map_or_else(|| memory.random(self.run), |own| own.replayed),
        ]
    }

    fn sum(&self, memory: &Memory, of: fn(&Rate) -> f64) -> f64 {
        let [read, random] = self.rates(memory);
        self.read * of(&read) + self.written * of(&memory.written()) + self.random * of(&random)
    }

    pub(super) fn ns(&self, memory: &Memory) -> f64 {
        self.sum(memory, |rate| rate.ns)
    }

    /// Rows of memory opened.
    pub(super) fn rows(&self, memory: &Memory) -> f64 {
        self.sum(memory, |rate| rate.rows)
    }

    pub(super) fn pj(&self, memory: &Memory) -> f64 {
        self.sum(memory, |rate| rate.pj)
    }

    /// The part of the data lines in [`Transfers::pj`].
    pub(super) fn io_pj(&self, memory: &Memory) -> f64 {
        self.sum(memory, |rate| rate.io_pj)
    }
}

/// Replayed sequences of a frame, by gathering.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct ReplayedRates {
    missed: Option<Replayed>,
    loaded: Option<Replayed>,
}

impl ReplayedRates {
    /// Sequences of a full frame or of a partial one.
    pub(super) fn of(replay: Option<&PathReplay>, work: &FrameWork) -> Self {
        let Some(replay) = replay else {
            return Self::default();
        };
        let own = match work.pixels < work.frame_pixels {
            true => replay.rest.unwrap_or(replay.full),
            false => replay.full,
        };
        Self {
            missed: own.missed,
            loaded: own.loaded,
        }
    }

    /// Rates of sequential and of random reads.
    pub(super) const fn rates(&self, gathering: Gathering) -> [Option<Replayed>; 2] {
        match gathering {
            Gathering::PixelOrder => [self.missed, self.missed],
            Gathering::Streamed | Gathering::Unit => [self.loaded, None],
        }
    }
}

/// Misses of the GPU's cache in pixel-centric order.
pub(super) fn missed_transfers(work: &FrameWork, known: &ReplayedRates) -> Transfers {
    let kernel = kernels::misses(work);
    Transfers {
        read: kernel.read_bytes,
        random: kernel.random_bytes,
        run: kernel.run_bytes,
        known: known.rates(Gathering::PixelOrder),
        ..Transfers::default()
    }
}

/// Reads and spills of the gathering unit for a step of a frame.
pub(super) fn unit_transfers(
    work: &FrameWork,
    step: &Batch,
    part: f64,
    known: &ReplayedRates,
) -> Transfers {
    let scattered = part * work.scattered_bytes as f64;
    let spilled = part * work.spilled_bytes as f64;
    Transfers {
        read: step.row_bytes as f64 - scattered + step.rit_read_bytes as f64 + spilled / 2.0,
        written: spilled / 2.0,
        random: scattered,
        run: run_bytes(work),
        known: known.rates(Gathering::Unit),
        // Of an MVoxel its rows and its entries.
        dma_transfers: 2 * step.mvoxels,
    }
}

/// Bytes of a row that is fetched on its own.
fn run_bytes(work: &FrameWork) -> f64 {
    work.reads.bytes as f64 / work.reads.reads.max(1) as f64
}
