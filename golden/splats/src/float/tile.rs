//! Compositing one tile in 64-bit floats.
//!
//! Each row of pixels is cut to the span in which a Gaussian exceeds the alpha threshold. The
//! groups of four pixels that hold these spans, except those in which all have stopped, are
//! composited without a branch: one at a time, or two in one vector where it holds eight pixels.
//! Every pixel decides by its own alpha.

use fearless_simd::prelude::*;

use super::exponential::exp;
use super::group::{COLUMNS, Group, SIDE};
use super::spans;
use super::splats::Splat;
use crate::profile::Rules;
use crate::view::TILE_PIXELS;

/// Bits of a column's rows.
const ROWS: u64 = (1 << SIDE) - 1;

/// A value for each pixel of a tile, group by group, column after column.
#[derive(Debug, Clone)]
#[repr(align(64))]
struct Plane([f64; TILE_PIXELS]);

/// Place of a pixel in a [`Plane`].
pub(super) const fn place(x: usize, y: usize) -> usize {
    (x / COLUMNS * SIDE + y) * COLUMNS + x % COLUMNS
}

/// The rules in the form that pixels use.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits {
    alpha_cap: f64,
    alpha_min: f64,
    /// Early-termination threshold (transmittance).
    stop: f64,
}

impl Limits {
    pub(super) fn new(rules: &Rules) -> Self {
        Self {
            alpha_cap: rules.alpha_cap,
            alpha_min: rules.alpha_min,
            stop: if rules.stop_at_equal {
                rules.stop_below.next_up()
            } else {
                rules.stop_below
            }
            // What is left of a pixel stays above 0.
            .max(f64::MIN_POSITIVE),
        }
    }
}

/// A Gaussian of a tile's list.
#[derive(Debug, Clone, Copy)]
pub(super) struct Entry<'a> {
    pub(super) splat: &'a Splat,
    /// View depth; not used unless depths are added up.
    pub(super) depth: f64,
    /// Its place among the tile's entries; not used unless there is a log.
    pub(super) place: u32,
}

/// What is counted of a tile, where that is asked for.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) struct TileCounts {
    /// Rendered pixels.
    pub(super) pixels: u32,
    /// (pixel, entry) pairs whose pixel had not stopped.
    pub(super) live: u64,
    /// (pixel, entry) pairs of the groups that were composited.
    pub(super) evaluated: u64,
    /// (pixel, entry) pairs that contributed to a pixel.
    pub(super) draws: u64,
    /// Pixels that terminated early.
    pub(super) stopped: u32,
}

/// The pixels of a tile while Gaussians are composited. Those that stopped and those that are not
/// rendered have a transmittance of NaN, which draws and stops nothing.
#[derive(Debug)]
pub(super) struct Pixels {
    origin: [f64; 2],
    transmittance: Plane,
    channels: [Plane; 3],
    depths: Plane,
    /// Final transmittance of pixels that stopped, and 1 of those that are not rendered.
    left: Plane,
    /// The entry that stopped each pixel, `u32::MAX` if none did, by place.
    stop: [u32; TILE_PIXELS],
    /// Groups with pixels that have not stopped, by bit.
    live: u64,
    pixels_live: u32,
    counts: TileCounts,
    /// The contributions of each row to p and to the squared distance, for the current Gaussian.
    row_p: [f64; SIDE],
    row_q: [f64; SIDE],
}

impl Pixels {
    pub(super) fn new() -> Self {
        let plane = || Plane([0.0; TILE_PIXELS]);
        Self {
            origin: [0.0; 2],
            transmittance: plane(),
            channels: [plane(), plane(), plane()],
            depths: plane(),
            left: plane(),
            stop: [u32::MAX; TILE_PIXELS],
            live: 0,
            pixels_live: 0,
            counts: TileCounts::default(),
            row_p: [0.0; SIDE],
            row_q: [0.0; SIDE],
        }
    }

    /// Starts a tile whose first pixel is at `origin`, with the pixels that are `chosen`.
    pub(super) fn start(&mut self, origin: [f64; 2], chosen: impl Fn(usize, usize) -> bool) {
        self.origin = origin;
        for channel in &mut self.channels {
            channel.0.fill(0.0);
        }
        self.depths.0.fill(0.0);
        self.stop.fill(u32::MAX);
        (self.live, self.pixels_live) = (0, 0);
        for x in 0..SIDE {
            for y in 0..SIDE {
                let at = place(x, y);
                let is_chosen = chosen(x, y);
                self.transmittance.0[at] = if is_chosen { 1.0 } else { f64::NAN };
                self.left.0[at] = 1.0;
                self.live |= u64::from(is_chosen) << (at / COLUMNS);
                self.pixels_live += u32::from(is_chosen);
            }
        }
        self.counts = TileCounts {
            pixels: self.pixels_live,
            ..TileCounts::default()
        };
    }

    /// Whether every pixel has stopped.
    #[inline(always)]
    pub(super) fn is_done(&self) -> bool {
        self.live == 0
    }

    /// Composites a Gaussian. `DEPTHS` adds up depths, and `LOG` counts; `drawn` gets a bit for each
    /// pixel, row by row.
    #[inline(always)]
    pub(super) fn draw<S: Simd, G: Group<S>, const DEPTHS: bool, const LOG: bool>(
        &mut self,
        simd: S,
        entry: Entry<'_>,
        limits: &Limits,
        mut drawn: Option<&mut [u64; TILE_PIXELS / 64]>,
    ) {
        let splat = entry.splat;
        let todo = spans::reached(simd, splat, self.origin) & self.live;
        if todo == 0 {
            return;
        }
        if LOG {
            self.counts.evaluated += u64::from(todo.count_ones()) * COLUMNS as u64;
        }
        self.rows(simd, splat);
        let l11 = G::splat(simd, splat.factor[0]);
        for column in 0..SIDE / COLUMNS {
            let mut rows = G::starts((todo >> (column * SIDE) & ROWS) as u16);
            if rows == 0 {
                continue;
            }
            let x = self.origin[0] + (column * COLUMNS) as f64;
            let x = G::columns(simd, std::array::from_fn(|i| x + i as f64));
            let p = (x - splat.mean[0]) * l11;
            while rows != 0 {
                let row = rows.trailing_zeros() as usize;
                rows &= rows - 1;
                let p = p + G::rows(simd, &self.row_p, row);
                let q = G::rows(simd, &self.row_q, row);
                let at = (column * SIDE + row) * COLUMNS;
                let draws = self.blend::<S, G, DEPTHS>(simd, entry, limits, at, p * p + q);
                if LOG {
                    let bits = draws.to_bitmask();
                    self.counts.draws += u64::from(bits.count_ones());
                    if let Some(drawn) = &mut drawn {
                        log(drawn, bits, column * COLUMNS, row);
                    }
                }
            }
        }
    }

    /// The contributions of all rows.
    #[inline(always)]
    fn rows<S: Simd>(&mut self, simd: S, splat: &Splat) {
        let [_, l21, l22] = splat.factor;
        for first in (0..SIDE).step_by(S::f64s::LEN) {
            let y = S::f64s::from_fn(simd, |i| (first + i) as f64);
            let d = (y + self.origin[1]) - splat.mean[1];
            let q = d * l22;
            (d * l21).store_slice(&mut self.row_p[first..first + S::f64s::LEN]);
            (q * q).store_slice(&mut self.row_q[first..first + S::f64s::LEN]);
        }
    }

    /// Composites the pixels from place `at` on, at these squared distances, and returns which of
    /// them the Gaussian contributes to.
    #[inline(always)]
    fn blend<S: Simd, G: Group<S>, const DEPTHS: bool>(
        &mut self,
        simd: S,
        entry: Entry<'_>,
        limits: &Limits,
        at: usize,
        squared: G,
    ) -> G::Mask {
        let splat = entry.splat;
        let group = at..at + G::LEN;
        let before = G::from_slice(simd, &self.transmittance.0[group.clone()]);
        let alpha = exp::<S, G>(squared * -0.5) * splat.opacity;
        let alpha = alpha.min(limits.alpha_cap);
        let after = before * (G::splat(simd, 1.0) - alpha);
        let is_seen = alpha.simd_ge(limits.alpha_min);
        let draws = is_seen & after.simd_ge(limits.stop);
        let weight = draws.select(alpha * before, G::splat(simd, 0.0));
        for (plane, colour) in self.channels.iter_mut().zip(splat.colour) {
            let sum = G::from_slice(simd, &plane.0[group.clone()]) + weight * colour;
            sum.store_slice(&mut plane.0[group.clone()]);
        }
        if DEPTHS {
            let sum = G::from_slice(simd, &self.depths.0[group.clone()]) + weight * entry.depth;
            sum.store_slice(&mut self.depths.0[group.clone()]);
        }
        let left = draws.select(after, before);
        left.store_slice(&mut self.transmittance.0[group]);
        let stops = is_seen & after.simd_lt(limits.stop);
        if stops.any_true() {
            self.stop(at, stops.to_bitmask(), entry.place);
        }
        draws
    }

    #[cold]
    #[inline(never)]
    fn stop(&mut self, at: usize, mut stops: u64, entry: u32) {
        while stops != 0 {
            let pixel = at + stops.trailing_zeros() as usize;
            stops &= stops - 1;
            self.left.0[pixel] = std::mem::replace(&mut self.transmittance.0[pixel], f64::NAN);
            self.stop[pixel] = entry;
            self.pixels_live -= 1;
            let first = pixel / COLUMNS * COLUMNS;
            let group = &self.transmittance.0[first..first + COLUMNS];
            if group.iter().all(|left| left.is_nan()) {
                self.live &= !(1 << (pixel / COLUMNS));
            }
        }
    }

    /// Ends a tile of `entries` entries and returns its counts.
    pub(super) fn finish(&mut self, entries: u64) -> TileCounts {
        let mut counts = self.counts;
        counts.stopped = counts.pixels - self.pixels_live;
        let stopped = self.stop.iter().filter(|stop| **stop != u32::MAX);
        counts.live = stopped.map(|stop| u64::from(*stop) + 1).sum();
        counts.live += u64::from(self.pixels_live) * entries;
        counts
    }

    /// Final transmittance of a pixel.
    #[inline(always)]
    pub(super) fn left(&self, place: usize) -> f64 {
        let left = self.transmittance.0[place];
        if left.is_nan() {
            self.left.0[place]
        } else {
            left
        }
    }

    /// Linear RGB of a pixel, without background.
    #[inline(always)]
    pub(super) fn colour(&self, place: usize) -> [f64; 3] {
        [0, 1, 2].map(|c: usize| self.channels[c].0[place])
    }

    /// Weighted mean depth of the Gaussians drawn at a pixel; infinite if there are none. Valid
    /// only if depths were added up.
    pub(super) fn depth(&self, place: usize) -> f64 {
        let weight = 1.0 - self.left(place);
        if weight > 0.0 {
            self.depths.0[place] / weight
        } else {
            f64::INFINITY
        }
    }

    /// The entry that stopped each pixel, row by row; `u32::MAX` if none did.
    pub(super) fn stops(&self) -> [u32; TILE_PIXELS] {
        std::array::from_fn(|pixel| self.stop[place(pixel % SIDE, pixel / SIDE)])
    }
}

/// Sets the bits of a group's pixels, or of two groups' one below the other.
fn log(drawn: &mut [u64; TILE_PIXELS / 64], bits: u64, x: usize, y: usize) {
    for (row, bits) in [bits & 0xf, bits >> COLUMNS].into_iter().enumerate() {
        let pixel = (y + row) * SIDE + x;
        if bits != 0 {
            drawn[pixel / 64] |= bits << (pixel % 64);
        }
    }
}
