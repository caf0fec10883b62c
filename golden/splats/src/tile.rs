//! Compositing one tile in 64-bit floats.
//!
//! Each row of pixels is cut to the span in which a Gaussian exceeds the alpha threshold. The
//! groups of four pixels that hold these spans, except those in which all have stopped, are
//! composited without a branch. Spans err outwards, and every pixel decides by its own alpha, so
//! no decision depends on a span.

use glam::DVec3;
use rayon::prelude::*;

use super::exponential::exp;
use super::profile::Rules;
use super::project::Projected;
use super::view::{TILE, TILE_PIXELS, View};
use potamoi_base::mask::Mask;

/// Pixels composited together: two vectors of the smallest machine, which hide each other's
/// latency.
const LANES: usize = 4;
/// Pixels on a side of a tile.
const SIDE: usize = TILE as usize;
/// Groups a row.
const GROUPS: usize = SIDE / LANES;
/// Rows whose groups fill a word of bits.
const ROWS_A_WORD: usize = 64 / GROUPS;
const WORDS: usize = SIDE / ROWS_A_WORD;

type Lanes = [f64; LANES];
/// A value for each pixel of a tile, row by row.
type Plane = [Lanes; TILE_PIXELS / LANES];

/// The region in which a Gaussian exceeds the alpha threshold.
#[derive(Debug, Clone, Copy)]
struct Reach {
    /// Corners of the bounding box in pixels, rounded outwards.
    low: [f32; 2],
    high: [f32; 2],
    /// The squared distance `p^2 + q^2`; negative if no alpha exceeds the threshold.
    squared: f64,
}

impl Reach {
    fn new(splat: &Projected, rules: &Rules) -> Self {
        let ratio = splat.opacity / rules.alpha_min;
        // Wider than rounding, here and in the pixels, can tell.
        let squared = 2.0 * ratio.ln() + 1e-6;
        let [xx, _, yy] = splat.footprint.covariance;
        let mean = splat.mean.to_array();
        let half = [xx, yy].map(|v| (v * squared.max(0.0)).sqrt());
        let slack = |v: f64| 0.01 + 1e-6 * v.abs();
        Self {
            low: [0, 1].map(|a| (mean[a] - half[a] - slack(mean[a]) - slack(half[a])) as f32),
            high: [0, 1].map(|a| (mean[a] + half[a] + slack(mean[a]) + slack(half[a])) as f32),
            squared,
        }
    }
}

/// Work and decisions of a tile.
#[derive(Debug)]
pub(crate) struct TileLog {
    /// Rendered pixels.
    pub(crate) pixels: u32,
    /// (pixel, entry) pairs whose pixel had not stopped.
    pub(crate) live: u64,
    /// (pixel, entry) pairs that were evaluated.
    pub(crate) evaluated: u64,
    /// (pixel, entry) pairs that contributed to a pixel.
    pub(crate) draws: u64,
    /// Pixels that terminated early.
    pub(crate) stopped: u64,
    /// For each entry the pixels that it contributed to, and for each pixel the entry that stopped
    /// it, if requested.
    pub(crate) decisions: Option<(Vec<[u64; TILE_PIXELS / 64]>, [u32; TILE_PIXELS])>,
}

/// A composited tile.
#[derive(Debug)]
pub(crate) struct Tile {
    channels: [Plane; 3],
    /// Weighted sums of depths, if requested.
    depths: Plane,
    /// Final transmittance per pixel.
    pub(crate) left: [f64; TILE_PIXELS],
    pub(crate) log: TileLog,
}

impl Tile {
    /// Linear RGB of a pixel, without background.
    pub(crate) fn colour(&self, pixel: usize) -> DVec3 {
        let channel = |c: usize| self.channels[c].as_flattened()[pixel];
        DVec3::new(channel(0), channel(1), channel(2))
    }

    /// Weighted mean depth of the Gaussians drawn at a pixel; infinite if there are none. Valid
    /// only if depths were requested.
    pub(crate) fn depth(&self, pixel: usize) -> f64 {
        let weight = 1.0 - self.left[pixel];
        if weight > 0.0 {
            self.depths.as_flattened()[pixel] / weight
        } else {
            f64::INFINITY
        }
    }
}

/// Requested results beside colours.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Outputs<'a> {
    /// Each skip and stop.
    pub(crate) decisions: bool,
    /// Depths.
    pub(crate) depths: bool,
    /// The pixels to render, by default all.
    pub(crate) only: Option<&'a Mask>,
}

/// The rules in the form that pixels use.
#[derive(Debug, Clone, Copy)]
struct Limits {
    alpha_cap: f64,
    pub alpha_min: f64,
    /// Early-termination threshold (transmittance).
    stop: f64,
}

/// Data shared by all tiles of a frame.
pub(crate) struct Canvas<'a> {
    view: &'a View,
    reaches: Vec<Reach>,
    limits: Limits,
}

impl<'a> Canvas<'a> {
    pub(crate) fn new(view: &'a View) -> Self {
        let rules = view.rules();
        let reach = |s| Reach::new(s, rules);
        Self {
            view,
            reaches: view.splats().par_iter().map(reach).collect(),
            limits: Limits {
                alpha_cap: rules.alpha_cap,
                alpha_min: rules.alpha_min,
                stop: if rules.stop_at_equal {
                    rules.stop_below.next_up()
                } else {
                    rules.stop_below
                }
                // Pixels outside of the frame have nothing left, and draw nothing.
                .max(f64::MIN_POSITIVE),
            },
        }
    }

    /// Composites the Gaussians of ranks `list`, front to back.
    pub(crate) fn render(&self, tile: usize, list: &[u32], wanted: Outputs<'_>) -> Tile {
        if wanted.depths {
            self.composite::<true>(tile, list, wanted)
        } else {
            self.composite::<false>(tile, list, wanted)
        }
    }

    fn composite<const DEPTHS: bool>(
        &self,
        tile: usize,
        list: &[u32],
        wanted: Outputs<'_>,
    ) -> Tile {
        let Outputs {
            decisions: log_decisions,
            only,
            ..
        } = wanted;
        let [corner, [columns, rows]] = self.view.tile_pixels(tile);
        let origin = corner.map(|v| f64::from(v) + self.view.rules().pixel_centre);
        let width = self.view.size()[0];
        let chosen = |x: u32, y: u32| {
            let pixel = (corner[1] + y) as usize * width as usize + (corner[0] + x) as usize;
            x < columns && y < rows && only.is_none_or(|mask| mask.has(pixel))
        };
        let mut state = State::new(origin, chosen);
        let mut drawn = vec![[0; TILE_PIXELS / 64]; if log_decisions { list.len() } else { 0 }];
        let near = origin.map(|v| v as f32);
        let far = near.map(|v| v + (TILE - 1) as f32);
        for (entry, rank) in list.iter().enumerate() {
            let reach = &self.reaches[*rank as usize];
            if reach.low[0] > far[0]
                || reach.high[0] < near[0]
                || reach.low[1] > far[1]
                || reach.high[1] < near[1]
            {
                continue;
            }
            if state.pixels_live == 0 {
                break;
            }
            let splat = &self.view.splats()[*rank as usize];
            let drawn = drawn.get_mut(entry);
            state.draw::<DEPTHS>(splat, reach, &self.limits, entry as u32, drawn);
        }
        state.finish(list.len(), log_decisions.then_some(drawn))
    }
}

/// Compositing state of a tile. Pixels that stopped and pixels that are not rendered have a
/// transmittance of 0, which draws and stops nothing.
struct State {
    origin: [f64; 2],
    transmittance: Plane,
    channels: [Plane; 3],
    depths: Plane,
    /// Initially 1 for pixels that are not to be rendered.
    left: [f64; TILE_PIXELS],
    stop: [u32; TILE_PIXELS],
    /// Groups with pixels that have not stopped, by bit.
    live: [u64; WORDS],
    pixels_live: u32,
    pixels: u32,
    draws: [u64; LANES],
    groups: u64,
    /// The contributions of each row to p and to the squared distance, for the current Gaussian.
    rows: [[f64; 2]; SIDE],
}

impl State {
    fn new(origin: [f64; 2], chosen: impl Fn(u32, u32) -> bool) -> Self {
        let mut state = Self {
            origin,
            transmittance: [[0.0; LANES]; TILE_PIXELS / LANES],
            channels: [[[0.0; LANES]; TILE_PIXELS / LANES]; 3],
            depths: [[0.0; LANES]; TILE_PIXELS / LANES],
            left: [1.0; TILE_PIXELS],
            stop: [u32::MAX; TILE_PIXELS],
            live: [0; WORDS],
            pixels_live: 0,
            pixels: 0,
            draws: [0; LANES],
            groups: 0,
            rows: [[0.0; 2]; SIDE],
        };
        for pixel in 0..TILE_PIXELS {
            let (x, y) = (pixel % SIDE, pixel / SIDE);
            if chosen(x as u32, y as u32) {
                state.transmittance[pixel / LANES][pixel % LANES] = 1.0;
                state.left[pixel] = 0.0;
                state.live[y / ROWS_A_WORD] |= groups(y, x, x + 1);
                state.pixels += 1;
            }
        }
        state.pixels_live = state.pixels;
        state
    }

    fn draw<const DEPTHS: bool>(
        &mut self,
        splat: &Projected,
        reach: &Reach,
        limits: &Limits,
        entry: u32,
        mut drawn: Option<&mut [u64; TILE_PIXELS / 64]>,
    ) {
        let todo = self.reached(splat, reach);
        for (word, (bits, live)) in todo.into_iter().zip(self.live).enumerate() {
            let mut bits = bits & live;
            self.groups += u64::from(bits.count_ones());
            while bits != 0 {
                let group = word * 64 + bits.trailing_zeros() as usize;
                bits &= bits - 1;
                let stops = self.blend::<DEPTHS>(splat, group, limits, &mut drawn);
                if stops.iter().fold(false, |any, s| any | s) {
                    self.stop(group, stops, entry);
                }
            }
        }
    }

    /// The groups that hold every pixel above the alpha threshold.
    fn reached(&mut self, splat: &Projected, reach: &Reach) -> [u64; WORDS] {
        let mut todo = [0; WORDS];
        let [l11, l21, l22] = splat.footprint.factor;
        let inverse = 1.0 / l11;
        let slope = l21 * inverse;
        let middle = splat.mean.x - self.origin[0];
        let top = first(f64::from(reach.low[1]) - self.origin[1]);
        let bottom = last(f64::from(reach.high[1]) - self.origin[1]);
        for y in top..bottom {
            let dy = self.origin[1] + y as f64 - splat.mean.y;
            let q = l22 * dy;
            self.rows[y] = [l21 * dy, q * q];
            let room = reach.squared - q * q;
            if room < 0.0 {
                continue;
            }
            // p^2 <= room, solved for x, and rounding.
            let shift = slope * dy;
            let half = room.sqrt() * inverse;
            let half = half + 1e-3 + 1e-9 * (splat.mean.x.abs() + shift.abs() + half);
            let left = first(middle - shift - half);
            let right = last(middle - shift + half);
            todo[y / ROWS_A_WORD] |= groups(y, left, right);
        }
        todo
    }

    /// Composites a group and returns which of its pixels the Gaussian stops.
    #[inline(always)]
    fn blend<const DEPTHS: bool>(
        &mut self,
        splat: &Projected,
        group: usize,
        limits: &Limits,
        drawn: &mut Option<&mut [u64; TILE_PIXELS / 64]>,
    ) -> [bool; LANES] {
        let l11 = splat.footprint.factor[0];
        let [row_p, q2] = self.rows[group / GROUPS];
        let column = group % GROUPS * LANES;
        let before = self.transmittance[group];
        let alpha: Lanes = std::array::from_fn(|i| {
            let x = self.origin[0] + (column + i) as f64;
            let p = l11 * (x - splat.mean.x) + row_p;
            let alpha = splat.opacity * exp(-0.5 * (p * p + q2));
            if alpha < limits.alpha_cap {
                alpha
            } else {
                limits.alpha_cap
            }
        });
        let after: Lanes = std::array::from_fn(|i| before[i] * (1.0 - alpha[i]));
        let seen: [bool; LANES] = std::array::from_fn(|i| alpha[i] >= limits.alpha_min);
        let goes_on: [bool; LANES] = std::array::from_fn(|i| after[i] >= limits.stop);
        let draws: [bool; LANES] = std::array::from_fn(|i| seen[i] & goes_on[i]);
        let weight: Lanes =
            std::array::from_fn(|i| if draws[i] { alpha[i] * before[i] } else { 0.0 });
        for (plane, colour) in self.channels.iter_mut().zip(splat.colour.to_array()) {
            for i in 0..LANES {
                plane[group][i] += colour * weight[i];
            }
        }
        if DEPTHS {
            for i in 0..LANES {
                self.depths[group][i] += splat.depth * weight[i];
            }
        }
        for i in 0..LANES {
            self.transmittance[group][i] = if draws[i] { after[i] } else { before[i] };
            self.draws[i] += u64::from(draws[i]);
        }
        if let Some(drawn) = drawn {
            for (i, draw) in draws.into_iter().enumerate() {
                let pixel = group * LANES + i;
                drawn[pixel / 64] |= u64::from(draw) << (pixel % 64);
            }
        }
        std::array::from_fn(|i| seen[i] & !goes_on[i] & (before[i] > 0.0))
    }

    #[cold]
    #[inline(never)]
    fn stop(&mut self, group: usize, stops: [bool; LANES], entry: u32) {
        for (i, _) in stops.into_iter().enumerate().filter(|(_, stops)| *stops) {
            let pixel = group * LANES + i;
            self.left[pixel] = std::mem::take(&mut self.transmittance[group][i]);
            self.stop[pixel] = entry;
            self.pixels_live -= 1;
        }
        if self.transmittance[group] == [0.0; LANES] {
            self.live[group / 64] &= !(1 << (group % 64));
        }
    }

    fn finish(mut self, entries: usize, drawn: Option<Vec<[u64; TILE_PIXELS / 64]>>) -> Tile {
        let transmittance = self.transmittance.as_flattened();
        let mut live = 0;
        for pixel in 0..TILE_PIXELS {
            if self.stop[pixel] != u32::MAX {
                live += u64::from(self.stop[pixel]) + 1;
            } else if self.left[pixel] == 0.0 {
                self.left[pixel] = transmittance[pixel];
                live += entries as u64;
            }
        }
        Tile {
            channels: self.channels,
            depths: self.depths,
            left: self.left,
            log: TileLog {
                pixels: self.pixels,
                live,
                evaluated: self.groups * LANES as u64,
                draws: self.draws.iter().sum(),
                stopped: u64::from(self.pixels - self.pixels_live),
                decisions: drawn.map(|drawn| (drawn, self.stop)),
            },
        }
    }
}

/// The bits, in the word of row `y`, of the groups with the pixels
/// `left..right` of that row.
fn groups(y: usize, left: usize, right: usize) -> u64 {
    let (from, to) = (left / LANES, right.div_ceil(LANES));
    let row = (1u64 << to).wrapping_sub(1 << from);
    // Where none is between, `to` may lie before `from`.
    (if to > from { row } else { 0 }) << (y % ROWS_A_WORD * GROUPS)
}

/// The first pixel at or after `x`, 0 to 16. NaN returns 0.
fn first(x: f64) -> usize {
    // Casts truncate towards zero and saturate: upwards when negated.
    let side = SIDE as f64;
    SIDE - (side - if x > 0.0 { x } else { 0.0 }) as usize
}

/// One past the last pixel at or before `x`, 0 to 16. NaN returns 16.
fn last(x: f64) -> usize {
    let one_past = x + 1.0;
    if one_past < SIDE as f64 {
        one_past as usize
    } else {
        SIDE
    }
}
