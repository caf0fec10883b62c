//! The reference splat unit: a job of entries, in order.

use potamoi_formats::config::{ExpConfig, SplatOpacity};
use potamoi_formats::record::MEAN;

use super::job::{Composited, SplatEntry, SplatJob, SplatPixel, SplatSettings, SplatUnitCounts};
use super::power_limits::{PowerLimits, StoredLimits, of_exponential};
use super::spans::{ROW_MASK, Span, Spans};
use super::tile_state::{Outcome, TileState};
use super::{Forms, TILE};
use crate::exponential::ReferenceExponential;

/// What an entry asks of the unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SplatPairs {
    /// Rows that may count, the first lowest.
    pub rows: u16,
    /// Pixels of each row whose power is computed, the first lowest.
    pub spans: [u16; TILE as usize],
    /// The product of opacity and exponential of each, U0.16; `None` where the cut drops the pair.
    pub alphas: [[Option<u32>; TILE as usize]; TILE as usize],
}

/// A part of the unit without which it computes the same pixels, with more work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SplatPart {
    /// Rows and spans: without them the power of every live pixel of the tile is computed.
    Spans,
    /// The cut: without it every power that is computed has an exponential.
    Cut,
}

/// Bit-exact model of the splat unit.
#[derive(Debug, Clone)]
pub struct ReferenceSplatUnit {
    exp: ReferenceExponential,
    power_bits: u32,
    exponential_bits: u32,
    exact: PowerLimits,
    limits: StoredLimits,
    settings: SplatSettings,
    tiles: Vec<TileState>,
    counts: SplatUnitCounts,
}

impl ReferenceSplatUnit {
    /// A unit for so many tiles, with an exponential of base e, of alpha output and with an input of 12
    /// or more fraction bits.
    #[must_use]
    pub fn new(exp: &ExpConfig, tiles: usize, settings: SplatSettings) -> Self {
        let (opacity, min) = (settings.opacity, settings.thresholds.alpha_min as i32);
        Self {
            exp: ReferenceExponential::new(exp),
            power_bits: exp.input.frac_bits(),
            exponential_bits: exp.output_bits,
            limits: StoredLimits::new(exp, opacity, min),
            exact: PowerLimits::new(exp, opacity, min),
            settings,
            tiles: vec![TileState::CLEAR; tiles],
            counts: SplatUnitCounts::default(),
        }
    }

    /// The settings.
    #[must_use]
    pub const fn settings(&self) -> &SplatSettings {
        &self.settings
    }

    /// Composites a job on clear tiles.
    pub fn run(&mut self, job: &SplatJob<'_>) -> Composited {
        self.tiles.clear();
        self.tiles.resize(job.tiles, TileState::CLEAR);
        self.counts = SplatUnitCounts::default();
        for entry in job.entries {
            self.composite(entry);
        }
        Composited {
            pixels: SplatPixel::of_tiles(&self.tiles).collect(),
            counts: self.counts,
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

    /// Composites an entry. One in a tile after those of the job is dropped: the unit raises a flag, and
    /// nothing else changes.
    pub fn composite(&mut self, entry: &SplatEntry) {
        let Some(tile) = self.tiles.get(usize::from(entry.slot)) else {
            return;
        };
        let live = tile.live;
        let Some((forms, limit)) = self.start(entry) else {
            return;
        };
        let exact = self.exact.of(entry.record.opacity);
        for span in self.spans(entry, &forms, limit) {
            let mask = span.mask & live[span.row as usize];
            for x in (0..TILE).filter(|x| mask >> x & 1 == 1) {
                self.counts.square_sums += 1;
                let power = self.power(forms.at(x, span.row));
                if power > limit {
                    continue;
                }
                self.counts.exponentials += 1;
                if exact.is_none_or(|exact| power > exact) {
                    continue;
                }
                self.counts.within_exact_limit += 1;
                let alpha = self.alpha(entry.record.opacity, power);
                let pixel = (span.row * TILE + x) as usize;
                let tile = &mut self.tiles[usize::from(entry.slot)];
                let thresholds = &self.settings.thresholds;
                match tile.composite(pixel, alpha, entry.record.colour, thresholds) {
                    Outcome::Drawn => self.counts.drawn += 1,
                    Outcome::Stopped => self.counts.stopped += 1,
                    Outcome::Skipped => {}
                }
            }
        }
    }

    /// What an entry asks of the unit, whatever pixels are live; `None` if nothing can count.
    #[must_use]
    pub fn pairs(&self, entry: &SplatEntry) -> Option<SplatPairs> {
        self.pairs_without(entry, None)
    }

    /// The same of a unit from which a part is left out.
    #[must_use]
    pub fn pairs_without(
        &self,
        entry: &SplatEntry,
        left_out: Option<SplatPart>,
    ) -> Option<SplatPairs> {
        let (forms, limit) = self.start(entry)?;
        let mut pairs = SplatPairs {
            rows: 0,
            spans: [0; TILE as usize],
            alphas: [[None; TILE as usize]; TILE as usize],
        };
        let spans = match left_out {
            Some(SplatPart::Spans) => whole_rows(entry, &forms),
            Some(SplatPart::Cut) | None => self.spans(entry, &forms, limit),
        };
        for span in spans {
            let row = span.row as usize;
            pairs.rows |= 1 << row;
            pairs.spans[row] = span.mask;
            for x in (0..TILE).filter(|x| span.mask >> x & 1 == 1) {
                let power = self.power(forms.at(x, span.row));
                let is_kept = power <= limit || left_out == Some(SplatPart::Cut);
                pairs.alphas[row][x as usize] =
                    is_kept.then(|| self.alpha(entry.record.opacity, power));
            }
        }
        Some(pairs)
    }

    /// Forms and limit of an entry; `None` if no power counts.
    fn start(&self, entry: &SplatEntry) -> Option<(Forms, u32)> {
        let limit = self.limits.of(entry.record.opacity)?;
        let half = i64::from(self.settings.is_centred) << (MEAN.frac_bits() - 1);
        let first = |at: u16| (i64::from(at) * i64::from(TILE)) << MEAN.frac_bits();
        let forms = Forms::new(&entry.record, entry.tile.map(|at| first(at) + half));
        Some((forms, limit))
    }

    /// Rows that may count, with the pixels of each that lie in the tile.
    fn spans(&self, entry: &SplatEntry, forms: &Forms, limit: u32) -> Vec<Span> {
        let spans = Spans::new(&entry.record, forms, limit, self.power_bits);
        in_tile(entry, spans.all())
    }

    /// The product of an opacity and the exponential of a power, U0.16.
    fn alpha(&self, opacity: u16, power: u32) -> u32 {
        let bits = self.exponential_bits;
        let exp = |power: u32| i64::from(self.exp.exp(power as i32));
        let alpha = match self.settings.opacity {
            SplatOpacity::Multiplied => {
                (i64::from(opacity) * exp(power) + (1 << (bits - 1))) >> bits
            }
            // Within the limit the sum is one of the exponential's codes.
            SplatOpacity::InPower => {
                let most = (8 << self.power_bits) - 1;
                of_exponential(exp((power + u32::from(opacity)).min(most)), bits)
            }
        };
        alpha as u32
    }

    /// Half the sum of the squares of two forms, a code of the exponential's input, saturating.
    fn power(&self, forms: [i32; 2]) -> u32 {
        let [p, q] = forms.map(|v| u64::from(v.unsigned_abs()));
        let shift = 33 - self.power_bits;
        let power = (p * p + q * q + (1 << (shift - 1))) >> shift;
        power.min((8 << self.power_bits) - 1) as u32
    }
}

/// Of spans the rows and pixels of an entry's tile that lie in the picture.
fn in_tile(entry: &SplatEntry, spans: impl Iterator<Item = Span>) -> Vec<Span> {
    let last = entry.last.map(|at| at.min(TILE as u8 - 1));
    let columns = ROW_MASK >> (TILE as u8 - 1 - last[0]);
    let spans = spans.filter(|span| span.row <= u32::from(last[1]));
    let in_tile = spans.map(|span| Span {
        mask: span.mask & columns,
        ..span
    });
    in_tile.collect()
}

/// All pixels of an entry's tile that lie in the picture; none if its start values are far.
fn whole_rows(entry: &SplatEntry, forms: &Forms) -> Vec<Span> {
    let rows = (0..TILE).filter(|_| !forms.is_far());
    in_tile(
        entry,
        rows.map(|row| Span {
            row,
            mask: ROW_MASK,
        }),
    )
}
