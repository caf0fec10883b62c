//! Compositing in the hardware's formats, through the vector unit.
//!
//! Entries wait in a queue for each tile. A wave takes the next entry of every tile and all live
//! pixels of those tiles at once, so that the vector unit gets long slices. The arithmetic of a
//! pixel does not depend on the waves.
//!
//! | step | operation | result |
//! |---|---|---|
//! | u | square sum of p, q (S15.16), shift 33 - G, half up | G fraction bits, saturating |
//! | e | exponential | U0.F |
//! | alpha | o times e, shift F, half up; cap; skip below 1/255 | U0.16 |
//! | T' | T times 65536 - alpha, shift 16, half up; to fewer bits if the rules carry fewer | U1.20 |
//! | colour | exact sum of (T - T') times the channel | 32 fraction bits |
//!
//! G and F are fraction bits of the exponential unit ([`Widths`]); the paper's are 13 and 16. Where the
//! vector unit takes fewer than 32 bits of p and q, they are first held within these: a form at either
//! end makes u the largest argument by itself ([`Widths::least_form`]).
//!
//! Early termination: a pixel stops where the exact product T (65536 - alpha) is below the
//! threshold, before rounding. After rounding, two capped samples would decide differently from a
//! float renderer.

use std::collections::BTreeMap;

use potamoi_formats::record::{MEAN, SplatRecord};
use potamoi_formats::units::{OpCode, VectorOp};

use super::error::RenderError;
use super::profile::Rules;
use super::transmittance::TRANSMITTANCE;
use super::view::{TILE, TILE_PIXELS};
use super::widths::{Widths, op};
use potamoi_reference::splat_unit::{Forms, Thresholds};
use potamoi_reference::{GatherTask, Product, Units};

const CLEAR: i32 = 1 << TRANSMITTANCE.frac_bits();
/// An alpha of 1, U0.16.
const FULL: i32 = 1 << 16;
/// Maximum number of tiles in a wave: a quarter of a million pixels.
const WAVE_TILES: usize = 1024;
/// Columns of the MAC array for a record: two forms, with weights in two halves of 16 bits unless
/// one half holds them, sign and integer bit included.
const fn form_columns(conic_bits: u32) -> u64 {
    if conic_bits <= 14 { 2 } else { 4 }
}

/// The thresholds of a profile as codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Limits {
    /// Cap of alpha, U0.16.
    pub(crate) alpha_cap: i32,
    /// Smaller alphas are skipped.
    pub alpha_min: i32,
    /// A pixel stops where T (65536 - alpha), 36 fraction bits, is below this threshold.
    pub(crate) stop: i64,
    /// Number of low transmittance bits that are not carried.
    pub(crate) spare: u8,
}

impl Limits {
    /// Rounds the rules of a profile to codes.
    #[must_use]
    pub fn new(rules: &Rules) -> Self {
        let full = f64::from(FULL);
        let stop = rules.stop_below * full * f64::from(CLEAR);
        Self {
            alpha_cap: (rules.alpha_cap * full).round() as i32,
            alpha_min: (rules.alpha_min * full).ceil() as i32,
            stop: if rules.stop_at_equal {
                stop.floor() as i64 + 1
            } else {
                stop.ceil() as i64
            },
            spare: TRANSMITTANCE
                .frac_bits()
                .saturating_sub(rules.transmittance_bits) as u8,
        }
    }

    /// The same for compositing pair by pair.
    #[must_use]
    pub const fn thresholds(&self) -> Thresholds {
        Thresholds {
            alpha_cap: self.alpha_cap as u32,
            alpha_min: self.alpha_min as u32,
            // Where no pixel stops, no product is below it.
            stop: if self.stop < 0 { 0 } else { self.stop as u64 },
            spare: self.spare as u32,
        }
    }
}

/// Compositing state of one tile.
#[derive(Debug)]
pub(crate) struct Tile {
    /// Centre of the first pixel, in codes of [`MEAN`].
    corner: [i64; 2],
    /// Position of the first pixel in the picture.
    first: [u32; 2],
    live: Vec<u8>,
    queue: Vec<SplatRecord>,
    head: usize,
    entry: u32,
    /// Transmittance per pixel, U1.20.
    pub(crate) transmittance: [i32; TILE_PIXELS],
    /// Colour per pixel, 32 fraction bits.
    pub(crate) colour: [[u64; 3]; TILE_PIXELS],
    pub(crate) stop: [u32; TILE_PIXELS],
    /// Pixels drawn by each entry, by bit; filled if decisions are logged.
    pub(crate) drawn: Vec<[u64; TILE_PIXELS / 64]>,
}

/// A pixel of a wave.
#[derive(Debug, Clone, Copy)]
struct Lane {
    tile: u32,
    pixel: u8,
}

/// Operands and results of one wave.
#[derive(Debug, Default)]
struct Wave {
    lanes: Vec<Lane>,
    a: Vec<i32>,
    b: Vec<i32>,
    out: Vec<i32>,
    opacity: Vec<i32>,
}

/// Compositing state of a ray group's tiles.
#[derive(Debug)]
pub(crate) struct Compositor {
    limits: Limits,
    widths: Widths,
    form_columns: u64,
    keep_decisions: bool,
    pub(crate) tiles: Vec<Tile>,
    queued: usize,
    wave: Wave,
    /// Elements computed by the vector unit, by operation.
    pub(crate) elements: BTreeMap<OpCode, u64>,
    pub(crate) drawn: u64,
}

const EXP: VectorOp = VectorOp::new(OpCode::Exp);

impl Compositor {
    /// `places` holds, for each slot, the first pixel of its tile and the number of the tile's
    /// columns and rows in the picture.
    pub(crate) fn new(
        rules: &Rules,
        widths: Widths,
        places: impl Iterator<Item = [[u32; 2]; 2]>,
        keep_decisions: bool,
    ) -> Self {
        let half = (rules.pixel_centre * 2f64.powi(MEAN.frac_bits() as i32)) as i64;
        let tiles = places
            .map(|[first, [columns, rows]]| Tile {
                corner: first.map(|v| (i64::from(v) << MEAN.frac_bits()) + half),
                first,
                live: (0..rows)
                    .flat_map(|y| (0..columns).map(move |x| (y * TILE + x) as u8))
                    .collect(),
                queue: Vec::new(),
                head: 0,
                entry: 0,
                transmittance: [CLEAR; TILE_PIXELS],
                colour: [[0; 3]; TILE_PIXELS],
                stop: [u32::MAX; TILE_PIXELS],
                drawn: Vec::new(),
            })
            .collect();
        Self {
            limits: Limits::new(rules),
            widths,
            form_columns: form_columns(rules.conic_bits),
            keep_decisions,
            tiles,
            queued: 0,
            wave: Wave::default(),
            elements: BTreeMap::new(),
            drawn: 0,
        }
    }

    /// Excludes the pixels that are not `wanted`.
    pub(crate) fn leave_out(&mut self, wanted: impl Fn([u32; 2]) -> bool) {
        for tile in &mut self.tiles {
            let first = tile.first;
            tile.live.retain(|pixel| {
                let at = [u32::from(*pixel) % TILE, u32::from(*pixel) / TILE];
                wanted([first[0] + at[0], first[1] + at[1]])
            });
        }
    }

    /// Reports the affine forms of a task to `units`: the records in a tile are columns of the MAC
    /// array, its live pixels are rows.
    pub(crate) fn tell_of_forms(&self, task: &GatherTask, units: &mut dyn Units) {
        let mut points: BTreeMap<u32, u64> = BTreeMap::new();
        for entry in &task.entries {
            *points.entry(entry.slot).or_default() += 1;
        }
        for (slot, points) in points {
            let live = self.tiles.get(slot as usize).map_or(0, |t| t.live.len());
            if live > 0 {
                units.multiplied(Product {
                    rows: live as u64,
                    depth: 2,
                    columns: points * self.form_columns,
                });
            }
        }
    }

    /// Appends to a tile's queue.
    pub(crate) fn push(&mut self, slot: usize, record: SplatRecord) {
        if let Some(tile) = self.tiles.get_mut(slot) {
            tile.queue.push(record);
            self.queued += 1;
        }
    }

    /// Number of waiting entries.
    pub(crate) fn queued(&self) -> usize {
        self.queued
    }

    /// Composites all waiting entries.
    pub(crate) fn run(&mut self, units: &mut dyn Units) -> Result<(), RenderError> {
        let count = self.tiles.len();
        for start in (0..count).step_by(WAVE_TILES) {
            let range = start..count.min(start + WAVE_TILES);
            while self.fill(range.clone()) {
                self.composite(units)?;
            }
        }
        for tile in &mut self.tiles {
            tile.queue.clear();
            tile.head = 0;
        }
        self.queued = 0;
        Ok(())
    }

    /// Collects the pixels of a wave; `false` if no entry waits.
    fn fill(&mut self, range: std::ops::Range<usize>) -> bool {
        let wave = &mut self.wave;
        wave.lanes.clear();
        wave.a.clear();
        wave.b.clear();
        wave.opacity.clear();
        let mut any = false;
        for t in range {
            let tile = &mut self.tiles[t];
            let Some(record) = tile.queue.get(tile.head) else {
                continue;
            };
            any = true;
            tile.head += 1;
            tile.entry += 1;
            if self.keep_decisions {
                tile.drawn.push([0; TILE_PIXELS / 64]);
            }
            let forms = Forms::new(record, tile.corner);
            for &pixel in &tile.live {
                let [p, q] = forms.at(u32::from(pixel) % TILE, u32::from(pixel) / TILE);
                wave.a.push(self.widths.held(p));
                wave.b.push(self.widths.held(q));
                wave.opacity.push(i32::from(record.opacity));
                wave.lanes.push(Lane {
                    tile: t as u32,
                    pixel,
                });
            }
        }
        any
    }

    /// Computes `out = op(a, b)` for the whole wave.
    fn vector(&mut self, units: &mut dyn Units, op: VectorOp) -> Result<(), RenderError> {
        let wave = &mut self.wave;
        wave.out.resize(wave.a.len(), 0);
        if wave.a.is_empty() {
            return Ok(());
        }
        *self.elements.entry(op.code).or_default() += wave.a.len() as u64;
        units
            .vector(op, &wave.a, &wave.b, &mut wave.out)
            .map_err(RenderError::Unit)
    }

    fn composite(&mut self, units: &mut dyn Units) -> Result<(), RenderError> {
        self.vector(units, self.widths.to_power())?;
        std::mem::swap(&mut self.wave.a, &mut self.wave.out);
        self.wave.b.fill(0);
        self.vector(units, EXP)?;
        std::mem::swap(&mut self.wave.a, &mut self.wave.opacity);
        std::mem::swap(&mut self.wave.b, &mut self.wave.out);
        self.vector(units, self.widths.to_alpha())?;

        // Alphas that count, and the pixels that they are for.
        let wave = &mut self.wave;
        let mut kept = 0;
        wave.a.clear();
        wave.b.clear();
        let mut stopped: Vec<u32> = Vec::new();
        for i in 0..wave.lanes.len() {
            let lane = wave.lanes[i];
            let alpha = wave.out[i].min(self.limits.alpha_cap);
            if alpha < self.limits.alpha_min {
                continue;
            }
            let tile = &mut self.tiles[lane.tile as usize];
            let pixel = usize::from(lane.pixel);
            let before = tile.transmittance[pixel];
            let product = i64::from(before) * i64::from(FULL - alpha);
            if product < self.limits.stop {
                tile.stop[pixel] = tile.entry - 1;
                if stopped.last() != Some(&lane.tile) {
                    stopped.push(lane.tile);
                }
                continue;
            }
            wave.a.push(before);
            wave.b.push(FULL - alpha);
            wave.lanes[kept] = lane;
            kept += 1;
        }
        for t in stopped {
            let tile = &mut self.tiles[t as usize];
            let stop = &tile.stop;
            tile.live.retain(|p| stop[usize::from(*p)] == u32::MAX);
        }
        wave.lanes.truncate(kept);
        let spare = self.limits.spare;
        self.vector(units, op(OpCode::Multiply, 16 + spare))?;
        self.drawn += kept as u64;
        for (lane, after) in self.wave.lanes.iter().zip(&self.wave.out) {
            let tile = &mut self.tiles[lane.tile as usize];
            let pixel = usize::from(lane.pixel);
            // The unit may be at fault: weights stay within 0 and T.
            let before = tile.transmittance[pixel];
            let after = (*after << spare).clamp(0, before);
            tile.transmittance[pixel] = after;
            let weight = u64::from((before - after) as u32);
            let record = &tile.queue[tile.head - 1];
            for (sum, channel) in tile.colour[pixel].iter_mut().zip(record.colour) {
                *sum += weight * u64::from(channel);
            }
            if let Some(drawn) = tile.drawn.last_mut() {
                drawn[pixel / 64] |= 1 << (pixel % 64);
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Profile;

    #[test]
    fn limits_are_the_measured_codes() {
        let inria = Limits::new(&Profile::Inria.rules());
        let codes = (inria.alpha_cap, inria.alpha_min, inria.stop);
        assert_eq!(codes, (64881, 258, 6_871_948));
        // No product equals 1e-4 exactly, so `<` and `<=` agree.
        assert_eq!(Limits::new(&Profile::Gsplat.rules()).stop, inria.stop);
        assert_eq!(Limits::new(&Profile::Gsplat.rules()).alpha_cap, 65470);
        // 257 is below 1/255 and 258 is not.
        let least = (65536.0f64 / 255.0).ceil();
        assert_eq!(least, 258.0);
    }

    /// Without early termination no product ends a pixel, in the splat unit as in the vector unit.
    #[test]
    fn a_threshold_that_is_not_there_stops_no_pixel() {
        let rules = Rules {
            stop_below: f64::NEG_INFINITY,
            ..Profile::Inria.rules()
        };
        assert_eq!(Limits::new(&rules).thresholds().stop, 0);
    }

    #[test]
    fn the_stop_needs_the_exact_product() {
        // Two samples capped at 0.99 leave just less than 1e-4 in the reference
        // and so stop. The exact 36-bit product says so; rounded to U1.20 it
        // says the opposite.
        let cap = i64::from(Limits::new(&Profile::Inria.rules()).alpha_cap);
        let left = 65536 - cap;
        let once = ((1i64 << 20) * left + (1 << 15)) >> 16;
        let product = once * left;
        let rounded = (product + (1 << 15)) >> 16;
        let stop = Limits::new(&Profile::Inria.rules()).stop;
        assert!(product < stop);
        // 1e-4 in U1.20 is 104.86: the rounded value would not tell.
        assert_eq!(rounded, 105);
        assert!(rounded as f64 / f64::from(CLEAR) >= 1e-4);
    }
}
