//! Bytes of jobs: how they are read, and what memory and the interconnect take for them.

use super::kernels;
use super::memory::{Memory, Rate};
use super::variant::Gathering;
use super::work::{Batch, FrameWork, PathReplay, Replayed};

/// Bytes of a job.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Transfers {
    pub(super) read: f64,
    pub(super) written: f64,
    pub(super) random: f64,
    /// Bytes of an access to anywhere.
    pub(super) run: f64,
    /// What those read in order take, and those read from anywhere, where their sequence is known.
    pub(super) known: [Option<Replayed>; 2],
    /// By the DMA.
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

    /// Of a byte read in order, and of one from anywhere.
    fn rates(&self, memory: &Memory) -> [Rate; 2] {
        let [read, random] = self.known;
        [
            read.map_or_else(|| memory.streamed(), |own| own.replayed),
            random.map_or_else(|| memory.random(self.run), |own| own.replayed),
        ]
    }

    pub(super) fn ns(&self, memory: &Memory) -> f64 {
        let [read, random] = self.rates(memory);
        self.read * read.ns + self.written * memory.written().ns + self.random * random.ns
    }

    /// Rows of memory that are opened.
    pub(super) fn rows(&self, memory: &Memory) -> f64 {
        let [read, random] = self.rates(memory);
        self.read * read.rows + self.written * memory.written().rows + self.random * random.rows
    }

    pub(super) fn pj(&self, memory: &Memory) -> f64 {
        let [read, random] = self.rates(memory);
        self.read * read.pj + self.written * memory.written().pj + self.random * random.pj
    }
}

/// Of a frame's accesses what is known, by who gathers.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Known {
    missed: Option<Replayed>,
    loaded: Option<Replayed>,
}

impl Known {
    /// Of a frame in full or of a part of one.
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

    /// Of bytes read in order, and of those from anywhere.
    pub(super) const fn rates(&self, gathering: Gathering) -> [Option<Replayed>; 2] {
        match gathering {
            Gathering::PixelOrder => [self.missed, self.missed],
            Gathering::Streamed | Gathering::Unit => [self.loaded, None],
        }
    }
}

/// What misses the GPU's cache in pixel-centric order.
pub(super) fn missed_transfers(work: &FrameWork, known: &Known) -> Transfers {
    let kernel = kernels::misses(work);
    Transfers {
        read: kernel.read_bytes,
        random: kernel.random_bytes,
        run: kernel.run_bytes,
        known: known.rates(Gathering::PixelOrder),
        ..Transfers::default()
    }
}

/// What the gathering unit reads and spills for a step, which is a part of a frame.
pub(super) fn unit_transfers(
    work: &FrameWork,
    step: &Batch,
    part: f64,
    known: &Known,
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

/// Bytes of a row that is fetched by itself.
fn run_bytes(work: &FrameWork) -> f64 {
    work.reads.bytes as f64 / work.reads.reads.max(1) as f64
}
