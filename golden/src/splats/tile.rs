//! Compositing one tile in 64-bit floats.
//!
//! Each row of pixels is cut to the span that a Gaussian reaches with an alpha
//! that counts, and the span is composited four pixels at a time, without a
//! branch. Spans err outwards, and the pixels decide by their own alphas: no
//! decision depends on a span.

use glam::DVec3;
use rayon::prelude::*;

use super::exponential::exp;
use super::profile::Rules;
use super::project::Projected;
use super::view::{TILE, TILE_PIXELS, View};

/// Pixels that are composited together.
const LANES: usize = 4;
/// Pixels on a side of a tile.
const SIDE: usize = TILE as usize;
/// Groups of a row.
const GROUPS: usize = SIDE / LANES;

type Lanes = [f64; LANES];
/// A value for each pixel of a tile, row by row.
type Plane = [[Lanes; GROUPS]; SIDE];

/// How far a Gaussian reaches with an alpha that counts.
#[derive(Debug, Clone, Copy)]
struct Reach {
    /// Corners of the box, in pixels, rounded outwards.
    low: [f32; 2],
    high: [f32; 2],
    /// The squared distance `p^2 + q^2`; negative where no alpha counts.
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

/// What a tile tells beside its pixels.
#[derive(Debug)]
pub(crate) struct TileLog {
    /// (pixel, entry) pairs of pixels that had not stopped.
    pub(crate) live: u64,
    /// (pixel, entry) pairs that were evaluated.
    pub(crate) evaluated: u64,
    /// (pixel, entry) pairs that were added to a pixel.
    pub(crate) draws: u64,
    /// Pixels that stopped.
    pub(crate) stopped: u64,
    /// For each entry the pixels that it was added to, and for each pixel the
    /// entry that stopped it; where asked for.
    pub(crate) decisions: Option<(Vec<[u64; TILE_PIXELS / 64]>, [u32; TILE_PIXELS])>,
}

/// A tile, composited.
#[derive(Debug)]
pub(crate) struct Tile {
    channels: [Plane; 3],
    /// Transmittance left.
    pub(crate) left: [f64; TILE_PIXELS],
    pub(crate) log: TileLog,
}

impl Tile {
    /// Linear RGB of a pixel, without background.
    pub(crate) fn colour(&self, pixel: usize) -> DVec3 {
        let channel = |c: usize| self.channels[c].as_flattened().as_flattened()[pixel];
        DVec3::new(channel(0), channel(1), channel(2))
    }
}

/// The rules as the pixels need them.
#[derive(Debug, Clone, Copy)]
struct Limits {
    alpha_cap: f64,
    alpha_min: f64,
    /// A pixel stops below this.
    stop: f64,
}

/// What all tiles of a frame share.
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
                },
            },
        }
    }

    /// Composites the Gaussians of ranks `list`, front to back.
    pub(crate) fn render(&self, tile: usize, list: &[u32], log_decisions: bool) -> Tile {
        let [corner, [columns, rows]] = self.view.tile_pixels(tile);
        let origin = corner.map(|v| f64::from(v) + self.view.rules().pixel_centre);
        let mut state = State::new(origin, columns, rows);
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
            state.draw(splat, reach, &self.limits, entry as u32, drawn);
        }
        state.finish(list.len(), columns, rows, log_decisions.then_some(drawn))
    }
}

/// A tile while it is composited. Pixels that stopped, and those outside of
/// the picture, have a transmittance of 0, which draws and stops nothing.
struct State {
    origin: [f64; 2],
    /// Where the pixels of a row lie.
    x: [Lanes; GROUPS],
    transmittance: Plane,
    channels: [Plane; 3],
    left: [f64; TILE_PIXELS],
    stop: [u32; TILE_PIXELS],
    /// Pixels of each row that have not stopped, by bit.
    live: [u32; SIDE],
    pixels_live: u32,
    draws: [u64; LANES],
    groups: u64,
}

/// One row of one Gaussian.
struct Row {
    mean_x: f64,
    l11: f64,
    /// What the row adds to p, and to the squared distance.
    p: f64,
    q2: f64,
    opacity: f64,
    colour: [f64; 3],
}

impl State {
    fn new(origin: [f64; 2], columns: u32, rows: u32) -> Self {
        let mut state = Self {
            origin,
            x: [[0.0; LANES]; GROUPS],
            transmittance: [[[0.0; LANES]; GROUPS]; SIDE],
            channels: [[[[0.0; LANES]; GROUPS]; SIDE]; 3],
            left: [0.0; TILE_PIXELS],
            stop: [u32::MAX; TILE_PIXELS],
            live: [0; SIDE],
            pixels_live: columns * rows,
            draws: [0; LANES],
            groups: 0,
        };
        for (i, x) in state.x.as_flattened_mut().iter_mut().enumerate() {
            *x = origin[0] + i as f64;
        }
        for y in 0..rows as usize {
            state.live[y] = (1 << columns) - 1;
            state.transmittance[y].as_flattened_mut()[..columns as usize].fill(1.0);
        }
        state
    }

    fn draw(
        &mut self,
        splat: &Projected,
        reach: &Reach,
        limits: &Limits,
        entry: u32,
        mut drawn: Option<&mut [u64; TILE_PIXELS / 64]>,
    ) {
        let [l11, l21, l22] = splat.footprint.factor;
        let inverse = 1.0 / l11;
        let slope = l21 * inverse;
        let middle = splat.mean.x - self.origin[0];
        let top = first(f64::from(reach.low[1]) - self.origin[1]);
        let bottom = last(f64::from(reach.high[1]) - self.origin[1]);
        for y in top..bottom {
            let dy = self.origin[1] + y as f64 - splat.mean.y;
            let q = l22 * dy;
            let room = reach.squared - q * q;
            let live = self.live[y];
            if room < 0.0 || live == 0 {
                continue;
            }
            // p^2 <= room, solved for x, and rounding.
            let shift = slope * dy;
            let half = room.sqrt() * inverse;
            let half = half + 1e-3 + 1e-9 * (splat.mean.x.abs() + shift.abs() + half);
            let left = first(middle - shift - half);
            let right = last(middle - shift + half);
            let row = Row {
                mean_x: splat.mean.x,
                l11,
                p: l21 * dy,
                q2: q * q,
                opacity: splat.opacity,
                colour: splat.colour.to_array(),
            };
            for group in left / LANES..right.div_ceil(LANES) {
                if live >> (group * LANES) & ((1 << LANES) - 1) == 0 {
                    continue;
                }
                self.blend(y, group, &row, limits, entry, &mut drawn);
            }
        }
    }

    #[inline(always)]
    fn blend(
        &mut self,
        y: usize,
        group: usize,
        row: &Row,
        limits: &Limits,
        entry: u32,
        drawn: &mut Option<&mut [u64; TILE_PIXELS / 64]>,
    ) {
        self.groups += 1;
        let x = &self.x[group];
        let before = self.transmittance[y][group];
        let alpha: Lanes = std::array::from_fn(|i| {
            let p = row.l11 * (x[i] - row.mean_x) + row.p;
            let alpha = row.opacity * exp(-0.5 * (p * p + row.q2));
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
        for (plane, colour) in self.channels.iter_mut().zip(row.colour) {
            for i in 0..LANES {
                plane[y][group][i] += colour * weight[i];
            }
        }
        for i in 0..LANES {
            self.transmittance[y][group][i] = if draws[i] { after[i] } else { before[i] };
            self.draws[i] += u64::from(draws[i]);
        }
        let at = y * SIDE + group * LANES;
        if let Some(drawn) = drawn {
            for i in 0..LANES {
                drawn[at / 64] |= u64::from(draws[i]) << ((at + i) % 64);
            }
        }
        let stops: [bool; LANES] =
            std::array::from_fn(|i| seen[i] & !goes_on[i] & (before[i] > 0.0));
        if stops.iter().fold(false, |any, s| any | s) {
            self.stop(y, group, &stops, entry);
        }
    }

    #[cold]
    #[inline(never)]
    fn stop(&mut self, y: usize, group: usize, stops: &[bool; LANES], entry: u32) {
        for (i, _) in stops.iter().enumerate().filter(|(_, s)| **s) {
            let pixel = y * SIDE + group * LANES + i;
            let transmittance = &mut self.transmittance[y][group][i];
            self.left[pixel] = std::mem::take(transmittance);
            self.stop[pixel] = entry;
            self.live[y] &= !(1 << (group * LANES + i));
            self.pixels_live -= 1;
        }
    }

    fn finish(
        mut self,
        entries: usize,
        columns: u32,
        rows: u32,
        drawn: Option<Vec<[u64; TILE_PIXELS / 64]>>,
    ) -> Tile {
        let transmittance = self.transmittance.as_flattened().as_flattened();
        let mut live = 0;
        for y in 0..rows as usize {
            for pixel in y * SIDE..y * SIDE + columns as usize {
                if self.stop[pixel] == u32::MAX {
                    self.left[pixel] = transmittance[pixel];
                    live += entries as u64;
                } else {
                    live += u64::from(self.stop[pixel]) + 1;
                }
            }
        }
        Tile {
            channels: self.channels,
            left: self.left,
            log: TileLog {
                live,
                evaluated: self.groups * LANES as u64,
                draws: self.draws.iter().sum(),
                stopped: u64::from(columns * rows - self.pixels_live),
                decisions: drawn.map(|drawn| (drawn, self.stop)),
            },
        }
    }
}

/// The first pixel at or after `x`, 0 to 16. NaN gives 0.
fn first(x: f64) -> usize {
    // Casts truncate towards zero and saturate: upwards when negated.
    let side = SIDE as f64;
    SIDE - (side - if x > 0.0 { x } else { 0.0 }) as usize
}

/// One past the last pixel at or before `x`, 0 to 16. NaN gives 16.
fn last(x: f64) -> usize {
    let one_past = x + 1.0;
    if one_past < SIDE as f64 {
        one_past as usize
    } else {
        SIDE
    }
}
