//! Stepwise model of the splat unit, one clock cycle a call (rules of
//! `docs/reference/splat-unit.md`). What a pair of pixel and record computes comes from the reference
//! unit; when it is computed, and what is live then, from here.
//!
//! Parts follow the data: [`front`] (forms and rows), [`walk`] (pixels of rows), [`lanes`]
//! (exponentials), [`tiles`] (transmittance, colour, and the pass that gives pixels).

mod front;
mod lanes;
mod tiles;
mod walk;

use std::rc::Rc;

use potamoi_formats::config::{Config, SuConfig};
use potamoi_reference::splat_unit::{
    ReferenceSplatUnit, SplatEntry, SplatPairs, SplatSettings, TileState,
};

use self::front::Front;
use self::lanes::Lanes;
use self::tiles::Tiles;
use self::walk::Walk;
use super::work::WorkError;

/// A beat of the input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SplatBeat<'a> {
    /// A record in a tile, and whether it ends the job.
    Record(&'a SplatEntry, bool),
    /// A word of the limits, or nothing; whether it ends the job.
    Other(bool),
}

/// Outputs of one cycle.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SplatOutputs {
    /// `s_axis_spl_tready`.
    pub ready: bool,
    /// The pixel on the output, and whether it is the last one.
    pub pixel: Option<(SplatPixel, bool)>,
    /// `idle`.
    pub idle: bool,
    /// Counters of the cycles before.
    pub counters: SplatCounters,
}

/// A pixel that the unit gives.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SplatPixel {
    /// U1.20.
    pub transmittance: u32,
    /// 32 fraction bits.
    pub colour: [u64; 3],
}

impl SplatPixel {
    /// The pixels of tiles, row by row.
    pub fn of_tiles(tiles: &[TileState]) -> impl Iterator<Item = Self> {
        tiles.iter().flat_map(|tile| {
            let both = tile.transmittance.iter().zip(tile.colour);
            both.map(|(transmittance, colour)| Self {
                transmittance: *transmittance,
                colour,
            })
        })
    }
}

/// Counters of the unit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct SplatCounters {
    /// Cycles in which it was not idle.
    pub busy: u64,
    /// Records in tiles.
    pub records: u64,
    /// Pairs of pixel and record whose power was computed.
    pub square_sums: u64,
    /// Of those, the pairs that the cut kept.
    pub exponentials: u64,
    /// Pairs that contributed to a pixel.
    pub drawn: u64,
    /// Pairs that ended a pixel.
    pub stopped: u64,
}

/// A record on its way.
#[derive(Debug)]
struct Entry {
    slot: usize,
    colour: [u16; 3],
    pairs: SplatPairs,
}

/// A pair of pixel and record.
#[derive(Debug, Clone)]
struct Pair {
    entry: Rc<Entry>,
    row: usize,
    column: usize,
}

impl Pair {
    fn alpha(&self) -> Option<u32> {
        self.entry.pairs.alphas[self.row][self.column]
    }
}

/// The splat unit between two clock edges.
pub struct SplatModel {
    twin: ReferenceSplatUnit,
    front: Front,
    walk: Walk,
    lanes: Lanes,
    tiles: Tiles,
    ending: bool,
    is_open: bool,
    counters: SplatCounters,
}

impl SplatModel {
    /// The unit after reset. `last_slot` is the last tile whose pixels it gives.
    ///
    /// # Errors
    /// A configuration that breaks its rules.
    pub fn new(
        config: &Config,
        su: &SuConfig,
        settings: SplatSettings,
        last_slot: usize,
    ) -> Result<Self, WorkError> {
        let tiles = su.tiles as usize;
        Ok(Self {
            twin: ReferenceSplatUnit::new(&config.vu.exp, 0, settings),
            front: Front::default(),
            walk: Walk::default(),
            lanes: Lanes::new(config, su)?,
            tiles: Tiles::new(tiles, su.lanes as usize, settings.thresholds, last_slot),
            ending: false,
            is_open: false,
            counters: SplatCounters::default(),
        })
    }

    /// A cycle with `cfg_clear` high and nothing offered.
    pub fn clear(&mut self) {
        self.step(None, false);
        self.counters = SplatCounters::default();
    }

    /// One clock cycle with a beat that is offered, or none, and a sink that takes a pixel, or not.
    pub fn step(&mut self, offered: Option<SplatBeat<'_>>, sink: bool) -> SplatOutputs {
        let draining = self.tiles.is_draining();
        let ready = !self.ending && !draining && self.front.is_ready();
        let is_idle = !self.is_open;
        let outputs = SplatOutputs {
            ready,
            pixel: self.tiles.pixel(),
            idle: is_idle,
            counters: self.counters,
        };
        let before = self.front.is_busy() || self.walk.is_busy();
        let flush = self.ending && !before;
        let drain = flush && !self.lanes.is_busy() && !self.tiles.is_busy();
        self.counters.busy += u64::from(!is_idle);

        // What moves, from the last part to the first.
        let vector = self.lanes.offered();
        let live = self.tiles.live();
        let pops = self.tiles.step(vector, drain, sink, &mut self.counters);
        let kept = self.walk.kept();
        let takes_power = self.lanes.is_ready();
        self.counters.exponentials += u64::from(kept.is_some() && takes_power);
        self.lanes.step(kept.filter(|_| takes_power), flush, pops);
        let walked = self.walk.step(takes_power, self.front.row());
        self.counters.square_sums += u64::from(walked.summed);
        let entry = match offered.filter(|_| ready) {
            Some(SplatBeat::Record(entry, _)) => {
                self.counters.records += 1;
                Some(self.entry(entry))
            }
            _ => None,
        };
        self.front
            .step(entry, &live, walked.takes_row, walked.released);
        let accepted = offered.filter(|_| ready);
        let ends = |beat| matches!(beat, SplatBeat::Record(_, true) | SplatBeat::Other(true));
        self.ending = accepted.is_some_and(ends) || self.ending && !drain;
        let last_given = sink && outputs.pixel.is_some_and(|(_, is_last)| is_last);
        self.is_open = accepted.is_some() || self.is_open && !last_given;
        outputs
    }

    fn entry(&self, own: &SplatEntry) -> Rc<Entry> {
        let none = SplatPairs {
            rows: 0,
            spans: [0; 16],
            alphas: [[None; 16]; 16],
        };
        Rc::new(Entry {
            slot: usize::from(own.slot),
            colour: own.record.colour,
            pairs: self.twin.pairs(own).unwrap_or(none),
        })
    }
}
