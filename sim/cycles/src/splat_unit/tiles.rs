//! Transmittance and colour of the tiles' pixels, pair by pair, and the pass that gives and clears them.

use potamoi_formats::config::SplatOpacity;
use potamoi_reference::splat_unit::{Outcome, SplatPixel, SplatSettings, TILE_PIXELS, TileState};

use super::lanes::Vector;
use super::{Pair, SplatCounters};

/// Stages after that in which a pair reads its transmittance: 4 to 12.
const STAGES: usize = 9;
/// Of these, the ones before the transmittance is written.
const BEFORE_WRITE: usize = 4;

/// Clocks from an exponential to the first pixel of the pass, where no other pair is behind it.
pub(super) const CYCLES: usize = STAGES + 5;
/// Those of the multiplication by an opacity.
pub(super) const MULTIPLIES: usize = 2;

/// Live pixels at the begin of a cycle.
pub(super) struct Live(Vec<[u16; 16]>);

impl Live {
    pub(super) fn row(&self, slot: usize, row: usize) -> u16 {
        self.0.get(slot).map_or(0, |tile| tile[row])
    }

    /// Rows with live pixels.
    pub(super) fn rows_alive(&self, slot: usize) -> u16 {
        let rows = (0..16).filter(|row| self.row(slot, *row) != 0);
        rows.fold(0, |all, row| all | 1 << row)
    }
}

/// Registers.
pub(super) struct Tiles {
    tiles: Vec<TileState>,
    settings: SplatSettings,
    lanes: usize,
    lane: usize,
    /// The pair whose exponential was taken from the vector: stage 0.
    operand: Option<Pair>,
    /// Stages 1 to 3; an opacity in the power goes from 0 to 3.
    rows: Option<Pair>,
    product: Option<Pair>,
    alpha: Option<Pair>,
    /// Those after the read of the transmittance.
    stages: [Option<Pair>; STAGES],
    /// The pair in stage 8 that ends its pixel.
    stopped: Option<Pair>,
    last_slot: usize,
    runs: bool,
    gives: bool,
    at: usize,
    holds: Option<(usize, bool)>,
}

impl Tiles {
    pub(super) fn new(
        tiles: usize,
        lanes: usize,
        settings: SplatSettings,
        last_slot: usize,
    ) -> Self {
        Self {
            tiles: vec![TileState::CLEAR; tiles],
            settings,
            lanes,
            lane: 0,
            operand: None,
            rows: None,
            product: None,
            alpha: None,
            stages: [const { None }; STAGES],
            stopped: None,
            last_slot,
            runs: true,
            gives: false,
            at: 0,
            holds: None,
        }
    }

    /// As after the pass that clears the pixels of all tiles.
    pub(super) const fn skip_clearing(&mut self) {
        self.runs = false;
    }

    pub(super) fn is_draining(&self) -> bool {
        self.runs || self.holds.is_some()
    }

    pub(super) fn is_busy(&self) -> bool {
        let flying = self
            .stages
            .iter()
            .chain([&self.stopped])
            .any(Option::is_some);
        let before = [&self.operand, &self.rows, &self.product, &self.alpha];
        flying || before.into_iter().any(Option::is_some)
    }

    /// The pixel that is offered, and whether it is the last one.
    pub(super) fn pixel(&self) -> Option<(SplatPixel, bool)> {
        let (at, is_last) = self.holds.filter(|_| self.gives)?;
        let (tile, pixel) = (&self.tiles[at / TILE_PIXELS], at % TILE_PIXELS);
        let own = SplatPixel {
            transmittance: tile.transmittance[pixel],
            colour: tile.colour[pixel],
        };
        Some((own, is_last))
    }

    pub(super) fn live(&self) -> Live {
        let mut live: Vec<_> = self.tiles.iter().map(|tile| tile.live).collect();
        if let Some(own) = &self.stopped {
            live[own.entry.slot][own.row] |= 1 << own.column;
        }
        Live(live)
    }

    /// One clock edge; whether the vector is taken.
    pub(super) fn step(
        &mut self,
        vector: Option<Vector>,
        drain: bool,
        sink: bool,
        counters: &mut SplatCounters,
    ) -> bool {
        self.drain(drain, sink);
        let pixel = |pair: &Pair| (pair.entry.slot, pair.row, pair.column);
        let waits = self.alpha.as_ref().is_some_and(|own| {
            let later = self.stages[..BEFORE_WRITE].iter().flatten();
            later.map(pixel).any(|other| other == pixel(own))
        });
        self.composite(counters);
        self.stages.rotate_right(1);
        self.stages[0] = None;
        if waits {
            return false;
        }
        self.stages[0] = self.alpha.take();
        let thresholds = &self.settings.thresholds;
        let counts = |pair: &Pair| {
            let alpha = pair.alpha().unwrap_or(0).min(thresholds.alpha_cap);
            alpha >= thresholds.alpha_min
        };
        let multiplied = match self.settings.opacity {
            SplatOpacity::Multiplied => {
                let product = self.product.take();
                self.product = self.rows.take();
                self.rows = self.operand.take();
                product
            }
            SplatOpacity::InPower => self.operand.take(),
        };
        self.alpha = multiplied.filter(counts);
        let Some(vector) = vector else {
            return false;
        };
        self.operand.clone_from(&vector[self.lane]);
        self.lane = (self.lane + 1) % self.lanes;
        self.lane == 0
    }

    /// What pairs in stages 5, 7 and 8 do. One of a pixel that has stopped leaves after stage 5, and one that
    /// stops its pixel after stage 7: the pixel is live until the clock after stage 8.
    fn composite(&mut self, counters: &mut SplatCounters) {
        let [_, fifth, _, seventh, eighth, .., last] = &mut self.stages;
        *last = None;
        counters.drawn += u64::from(eighth.is_some());
        counters.stopped += u64::from(self.stopped.take().is_some());
        fifth.take_if(|pair| {
            let live = self.tiles[pair.entry.slot].live[pair.row];
            live >> pair.column & 1 == 0
        });
        self.stopped = seventh.take_if(|pair| {
            let tile = &mut self.tiles[pair.entry.slot];
            let at = 16 * pair.row + pair.column;
            let alpha = pair.alpha().unwrap_or(0);
            let outcome = tile.composite(at, alpha, pair.entry.colour, &self.settings.thresholds);
            outcome == Outcome::Stopped
        });
    }

    /// The pass over all pixels.
    fn drain(&mut self, begins: bool, sink: bool) {
        let taken = !self.gives || sink;
        let fetches = self.runs && (self.holds.is_none() || taken);
        if let Some((at, _)) = self.holds.take_if(|_| taken) {
            let (tile, pixel) = (&mut self.tiles[at / TILE_PIXELS], at % TILE_PIXELS);
            tile.transmittance[pixel] = TileState::CLEAR.transmittance[0];
            tile.colour[pixel] = [0; 3];
            tile.live[pixel / 16] = u16::MAX;
        }
        if fetches {
            let last = if self.gives {
                self.last_slot
            } else {
                self.tiles.len() - 1
            };
            let is_end = self.at == (last + 1) * TILE_PIXELS - 1;
            self.holds = Some((self.at, is_end));
            self.at = if is_end { 0 } else { self.at + 1 };
            self.runs = !is_end;
        }
        self.runs |= begins;
        self.gives |= begins;
    }
}
