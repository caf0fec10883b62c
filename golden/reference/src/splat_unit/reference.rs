//! The reference splat unit: a job of entries, in order.

use potamoi_formats::config::ExpConfig;
use potamoi_formats::record::{MEAN, SplatRecord};

use super::power_limits::{CoarseLimits, PowerLimits};
use super::spans::{ROW_MASK, Span, Spans};
use super::tile_state::{Outcome, Thresholds, TileState};
use super::{Forms, TILE};
use crate::exponential::ReferenceExponential;

/// A record in a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SplatEntry {
    /// The tile's number in the unit.
    pub slot: u16,
    /// The tile's column and row in the picture.
    pub tile: [u16; 2],
    /// The last column and row of the tile that lie in the picture, 0 to 15.
    pub last: [u8; 2],
    /// The record.
    pub record: SplatRecord,
}

/// Settings of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SplatSettings {
    /// Thresholds of the rules.
    pub thresholds: Thresholds,
    /// Whether pixel centres lie at half a pixel, not at 0.
    pub is_centred: bool,
}

/// Work of the unit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct SplatUnitCounts {
    /// Square sums, one for each pair of pixel and Gaussian in a span.
    pub square_sums: u64,
    /// Exponentials, one for each pair that the cut keeps.
    pub exponentials: u64,
    /// Pairs that contribute to a pixel.
    pub drawn: u64,
    /// Pairs at which a pixel terminates early.
    pub stopped: u64,
}

/// Bit-exact model of the splat unit.
#[derive(Debug, Clone)]
pub struct ReferenceSplatUnit {
    exp: ReferenceExponential,
    power_bits: u32,
    exponential_bits: u32,
    limits: CoarseLimits,
    settings: SplatSettings,
    tiles: Vec<TileState>,
    counts: SplatUnitCounts,
}

impl ReferenceSplatUnit {
    /// A unit for so many tiles, with an exponential of base e, of alpha output and with an input of 12
    /// or more fraction bits.
    #[must_use]
    pub fn new(exp: &ExpConfig, tiles: usize, settings: SplatSettings) -> Self {
        let alpha_min = settings.thresholds.alpha_min as i32;
        Self {
            exp: ReferenceExponential::new(exp),
            power_bits: exp.input.frac_bits(),
            exponential_bits: exp.output_bits,
            limits: CoarseLimits::new(&PowerLimits::new(exp, alpha_min)),
            settings,
            tiles: vec![TileState::CLEAR; tiles],
            counts: SplatUnitCounts::default(),
        }
    }

    /// The pixels of all tiles.
    #[must_use]
    pub fn tiles(&self) -> &[TileState] {
        &self.tiles
    }

    /// Work since construction.
    #[must_use]
    pub const fn counts(&self) -> SplatUnitCounts {
        self.counts
    }

    /// Composites an entry. An entry of a slot that the unit does not have changes nothing.
    pub fn composite(&mut self, entry: &SplatEntry) {
        let limit = self.limits.of(entry.record.opacity);
        let (Some(tile), Some(limit)) = (self.tiles.get(usize::from(entry.slot)), limit) else {
            return;
        };
        let half = i64::from(self.settings.is_centred) << (MEAN.frac_bits() - 1);
        let first = |at: u16| (i64::from(at) * i64::from(TILE)) << MEAN.frac_bits();
        let forms = Forms::new(&entry.record, entry.tile.map(|at| first(at) + half));
        let last = entry.last.map(|at| at.min(TILE as u8 - 1));
        let columns = ROW_MASK >> (TILE as u8 - 1 - last[0]);
        let live = tile.live;
        for span in Spans::new(&entry.record, &forms, limit, self.power_bits).all() {
            if span.row <= u32::from(last[1]) {
                let mask = span.mask & columns & live[span.row as usize];
                self.row(entry, &forms, Span { mask, ..span }, limit);
            }
        }
    }

    /// Composites the pixels of a span.
    fn row(&mut self, entry: &SplatEntry, forms: &Forms, span: Span, limit: u32) {
        let record = &entry.record;
        for x in (0..TILE).filter(|x| span.mask >> x & 1 == 1) {
            self.counts.square_sums += 1;
            let power = self.power(forms.at(x, span.row));
            if power > limit {
                continue;
            }
            self.counts.exponentials += 1;
            let e = i64::from(self.exp.exp(power as i32));
            let bits = self.exponential_bits;
            let alpha = (i64::from(record.opacity) * e + (1 << (bits - 1))) >> bits;
            let pixel = (span.row * TILE + x) as usize;
            let tile = &mut self.tiles[usize::from(entry.slot)];
            let thresholds = &self.settings.thresholds;
            match tile.composite(pixel, alpha as u32, record.colour, thresholds) {
                Outcome::Drawn => self.counts.drawn += 1,
                Outcome::Stopped => self.counts.stopped += 1,
                Outcome::Skipped => {}
            }
        }
    }

    /// Half the sum of the squares of two forms, a code of the exponential's input, saturating.
    fn power(&self, forms: [i32; 2]) -> u32 {
        let [p, q] = forms.map(|v| u64::from(v.unsigned_abs()));
        let shift = 33 - self.power_bits;
        let power = (p * p + q * q + (1 << (shift - 1))) >> shift;
        power.min((8 << self.power_bits) - 1) as u32
    }
}
