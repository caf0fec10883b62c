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

/// Sizes and parts of the unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SplatUnitParts {
    /// Tiles in flight.
    pub tiles: usize,
    /// Whether pairs above the limit of their opacity are dropped before the exponential.
    pub cut: bool,
    /// Whether pixels outside the Gaussian's span are left out.
    pub spans: bool,
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
    /// Entries: (tile, Gaussian) pairs.
    pub entries: u64,
    /// Rows of tiles that were searched for pixels.
    pub rows: u64,
    /// Square sums, one for each pair of pixel and Gaussian in a span.
    pub square_sums: u64,
    /// Exponentials, one for each pair that the cut keeps.
    pub exponentials: u64,
    /// Pairs that contribute to a pixel.
    pub drawn: u64,
    /// Pairs at which a pixel terminates early.
    pub stopped: u64,
}

/// A searched row of an entry: its pixels, and how many of them the cut keeps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Walked {
    /// The row and its live pixels within the span.
    pub span: Span,
    /// Exponentials.
    pub kept: u32,
}

/// Bit-exact model of the splat unit.
#[derive(Debug, Clone)]
pub struct ReferenceSplatUnit {
    parts: SplatUnitParts,
    exp: ReferenceExponential,
    power_bits: u32,
    exponential_bits: u32,
    limits: CoarseLimits,
    settings: SplatSettings,
    tiles: Vec<TileState>,
    counts: SplatUnitCounts,
}

impl ReferenceSplatUnit {
    /// A unit with an exponential of base e, of alpha output and with 12 or more fraction bits.
    #[must_use]
    pub fn new(exp: &ExpConfig, parts: SplatUnitParts, settings: SplatSettings) -> Self {
        let alpha_min = settings.thresholds.alpha_min as i32;
        let tiles = vec![TileState::new([TILE; 2]); parts.tiles];
        Self {
            parts,
            exp: ReferenceExponential::new(exp),
            power_bits: exp.input.frac_bits(),
            exponential_bits: exp.output_bits,
            limits: CoarseLimits::new(&PowerLimits::new(exp, alpha_min)),
            settings,
            tiles,
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

    /// Makes all pixels clear and live.
    pub fn clear(&mut self) {
        self.tiles.fill(TileState::new([TILE; 2]));
    }

    /// Composites an entry. Returns the rows that were searched. An entry of a slot that the unit
    /// does not have changes nothing.
    pub fn composite(&mut self, entry: &SplatEntry) -> Vec<Walked> {
        self.counts.entries += 1;
        let slot = usize::from(entry.slot);
        let Some(tile) = self.tiles.get(slot) else {
            return vec![];
        };
        let half = i64::from(self.settings.is_centred) << (MEAN.frac_bits() - 1);
        let corner = entry
            .tile
            .map(|at| (i64::from(at) * i64::from(TILE) << MEAN.frac_bits()) + half);
        let forms = Forms::new(&entry.record, corner);
        let limit = match self.parts.cut {
            true => match self.limits.of(entry.record.opacity) {
                Some(limit) => limit,
                None => return vec![],
            },
            false => u32::MAX,
        };
        let spans = Spans::new(&entry.record, &forms, limit, self.power_bits);
        let columns = ROW_MASK >> (TILE as u8 - 1 - entry.last[0].min(TILE as u8 - 1));
        let rows = if self.parts.spans {
            spans.rows()
        } else {
            ROW_MASK
        };
        let live = tile.live;
        let mut walked = vec![];
        for row in (0..=u32::from(entry.last[1])).filter(|row| rows >> row & 1 == 1) {
            let alive = live[row as usize] & columns;
            // A row that has stopped is not searched.
            if alive == 0 {
                continue;
            }
            let reached = if self.parts.spans {
                spans.pixels(row)
            } else {
                ROW_MASK
            };
            let span = Span {
                row,
                mask: reached & alive,
            };
            let kept = self.row(entry, &forms, span, limit);
            walked.push(Walked { span, kept });
        }
        self.counts.rows += walked.len() as u64;
        walked
    }

    /// Composites the pixels of a span. Returns the number of exponentials.
    fn row(&mut self, entry: &SplatEntry, forms: &Forms, span: Span, limit: u32) -> u32 {
        let record = &entry.record;
        let mut kept = 0;
        for x in (0..TILE).filter(|x| span.mask >> x & 1 == 1) {
            self.counts.square_sums += 1;
            let power = self.power(forms.at(x, span.row));
            if power > limit {
                continue;
            }
            kept += 1;
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
        self.counts.exponentials += u64::from(kept);
        kept
    }

    /// Half the sum of the squares of two forms, a code of the exponential's input, saturating.
    fn power(&self, forms: [i32; 2]) -> u32 {
        let [p, q] = forms.map(|v| u64::from(v.unsigned_abs()));
        let shift = 33 - self.power_bits;
        let power = (p * p + q * q + (1 << (shift - 1))) >> shift;
        power.min((8 << self.power_bits) - 1) as u32
    }
}
