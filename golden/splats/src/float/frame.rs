//! A picture from the lists of its tiles.

use fearless_simd::{Level, dispatch, f64x4, f64x8, prelude::*};
use rayon::prelude::*;

use super::group::Group;
use super::group::SIDE;
use super::lists::{List, Lists};
use super::splats::{CHUNK, Splats};
use super::tile::{Entry, Limits, Pixels, TileCounts, place};
use super::{FloatFrame, FloatStats};
use crate::decisions::Decisions;
use crate::view::{Raster, TILE, TILE_PIXELS, View};
use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;

/// Pixels of a tile that each entry of its list contributed to.
type Drawn = Vec<[u64; TILE_PIXELS / 64]>;

/// All that the tiles of a frame share.
pub(super) struct Canvas<'a> {
    pub(super) raster: Raster,
    pub(super) limits: Limits,
    /// Centre of pixel 0.
    pub(super) pixel_centre: f64,
    pub(super) splats: Splats,
    /// View depths in chunks as `splats`, if depths are asked for.
    pub(super) depths: Option<Vec<Vec<f64>>>,
    pub(super) lists: Vec<Lists>,
    pub(super) background: [f64; 3],
    /// The pixels to render, by default all.
    pub(super) only: Option<&'a Mask>,
}

/// The pixels of a row of tiles, line after line.
struct Band<'a> {
    row: usize,
    rgb: &'a mut [[f32; 3]],
    left: &'a mut [f64],
    /// Empty unless depths are asked for.
    depth: &'a mut [f64],
}

/// What happened in a tile.
struct TileLog {
    counts: TileCounts,
    /// For each entry of the tile's list, the pixels that it contributed to.
    drawn: Drawn,
    /// For each pixel, the entry that stopped it.
    stop: [u32; TILE_PIXELS],
}

impl Canvas<'_> {
    /// Renders the picture.
    pub(super) fn render(&self, level: Level) -> FloatFrame {
        self.composite::<false>(level, |_| 0).0
    }

    /// Renders the picture of a view and tells what happened. `first` are the first entries of the tiles.
    pub(super) fn logged(&self, level: Level, view: &View, first: Vec<usize>) -> FloatFrame {
        let entries = |t: usize| (first[t + 1] - first[t]) as u64;
        let (frame, logs) = self.composite::<true>(level, entries);
        let mut stats = FloatStats {
            culled: view.culled() as u64,
            visible: view.splats().len() as u64,
            ..FloatStats::default()
        };
        let mut decisions = Decisions::new(first.clone());
        let columns = view.grid()[0] as usize;
        for (t, log) in logs.into_iter().flatten().enumerate() {
            let counts = log.counts;
            if counts.pixels > 0 {
                stats.entries += entries(t);
            }
            stats.exponentials += counts.live;
            stats.evaluated += counts.evaluated;
            stats.drawn += counts.draws;
            stats.stopped += u64::from(counts.stopped);
            decisions.stop[t] = log.stop;
            let list = self.list(t / columns, t % columns);
            for (entry, drawn) in list.entries.iter().zip(log.drawn) {
                decisions.drawn[first[t] + *entry as usize] = drawn;
            }
        }
        FloatFrame {
            stats: Some(stats),
            decisions: Some(decisions),
            ..frame
        }
    }

    fn list(&self, row: usize, column: usize) -> List<'_> {
        let holds = |own: &&Lists| own.rows.contains(&row);
        let lists = self.lists.iter().find(holds);
        lists.map_or(List::EMPTY, |own| own.of(row, column))
    }

    /// `entries` is the number of a tile's entries, also of those that its list leaves out.
    fn composite<const LOG: bool>(
        &self,
        level: Level,
        entries: impl Fn(usize) -> u64 + Sync,
    ) -> (FloatFrame, Vec<Vec<TileLog>>) {
        let [width, height] = self.raster.size;
        let pixels = width as usize * height as usize;
        let mut picture = Picture::filled(width, height, [0.0; 3]);
        let mut transmittance = vec![0.0; pixels];
        let has_depths = self.depths.is_some();
        let mut depth = vec![0.0; if has_depths { pixels } else { 0 }];
        // Bands of one tile's height: each thread writes pixels of its own.
        let band = SIDE * width as usize;
        let mut depths = depth.chunks_mut(band);
        let bands = (picture.rgb.chunks_mut(band))
            .zip(transmittance.chunks_mut(band))
            .enumerate()
            .map(|(row, (rgb, left))| Band {
                row,
                rgb,
                left,
                depth: depths.next().unwrap_or_default(),
            });
        let bands: Vec<Band<'_>> = bands.collect();
        let logs = bands
            .into_par_iter()
            .map(|band| dispatch!(level, simd => self.band::<_, LOG>(simd, band, &entries)))
            .collect();
        let frame = FloatFrame {
            picture,
            transmittance,
            depth: has_depths.then_some(depth),
            stats: None,
            decisions: None,
        };
        (frame, logs)
    }

    #[inline(always)]
    fn band<S: Simd, const LOG: bool>(
        &self,
        simd: S,
        band: Band<'_>,
        entries: &impl Fn(usize) -> u64,
    ) -> Vec<TileLog> {
        // Two groups together where a vector holds them.
        match (S::f64s::LEN >= f64x8::<S>::LEN, self.depths.is_none()) {
            (false, true) => self.tiles::<S, f64x4<S>, false, LOG>(simd, band, entries),
            (false, false) => self.tiles::<S, f64x4<S>, true, LOG>(simd, band, entries),
            (true, true) => self.tiles::<S, f64x8<S>, false, LOG>(simd, band, entries),
            (true, false) => self.tiles::<S, f64x8<S>, true, LOG>(simd, band, entries),
        }
    }

    #[inline(always)]
    fn tiles<S: Simd, G: Group<S>, const DEPTHS: bool, const LOG: bool>(
        &self,
        simd: S,
        mut band: Band<'_>,
        entries: &impl Fn(usize) -> u64,
    ) -> Vec<TileLog> {
        let mut logs = vec![];
        let mut pixels = Pixels::new();
        let columns = self.raster.grid().columns as usize;
        let depths = self.depths.as_deref().unwrap_or_default();
        for column in 0..columns {
            let tile = band.row * columns + column;
            let list = self.list(band.row, column);
            let [corner, [wide, high]] = self.raster.tile_pixels(tile);
            self.start(&mut pixels, corner, [wide, high]);
            let mut drawn = vec![[0; TILE_PIXELS / 64]; if LOG { list.slots.len() } else { 0 }];
            for (at, slot) in list.slots.iter().enumerate() {
                if pixels.is_done() {
                    break;
                }
                let depth = match DEPTHS {
                    true => depths[*slot as usize / CHUNK][*slot as usize % CHUNK],
                    false => 0.0,
                };
                let entry = Entry {
                    splat: self.splats.at(*slot),
                    depth,
                    place: if LOG { list.entries[at] } else { 0 },
                };
                let drawn = if LOG { drawn.get_mut(at) } else { None };
                pixels.draw::<S, G, DEPTHS, LOG>(simd, entry, &self.limits, drawn);
            }
            self.put::<DEPTHS>(&pixels, &mut band, corner[0] as usize, [wide, high]);
            if LOG {
                logs.push(TileLog {
                    counts: pixels.finish(entries(tile)),
                    drawn,
                    stop: pixels.stops(),
                });
            }
        }
        logs
    }

    /// Starts the tile with the first pixel `corner` and this size.
    fn start(&self, pixels: &mut Pixels, corner: [u32; 2], size: [u32; 2]) {
        let origin = corner.map(|v| f64::from(v) + self.pixel_centre);
        match self.only {
            None if size == [TILE; 2] => pixels.start(origin, |_, _| true),
            only => {
                let width = self.raster.size[0] as usize;
                let [[left, top], [wide, high]] = [corner, size].map(|own| own.map(|v| v as usize));
                pixels.start(origin, |x, y| {
                    let is_inside = x < wide && y < high;
                    is_inside && only.is_none_or(|mask| mask.has((top + y) * width + left + x))
                });
            }
        }
    }

    /// Writes the pixels of a tile into its band, from column `left` on.
    #[inline(always)]
    fn put<const DEPTHS: bool>(
        &self,
        pixels: &Pixels,
        band: &mut Band<'_>,
        left: usize,
        [wide, high]: [u32; 2],
    ) {
        let width = self.raster.size[0] as usize;
        for y in 0..high as usize {
            let line = y * width + left..y * width + left + wide as usize;
            let rgb = &mut band.rgb[line.clone()];
            let clear = &mut band.left[line.clone()];
            for (x, (rgb, clear)) in rgb.iter_mut().zip(clear).enumerate() {
                let from = place(x, y);
                let left = pixels.left(from);
                let colour = pixels.colour(from);
                *rgb = [0, 1, 2].map(|c| (colour[c] + left * self.background[c]) as f32);
                *clear = left;
            }
            if DEPTHS {
                for (x, depth) in band.depth[line].iter_mut().enumerate() {
                    *depth = pixels.depth(place(x, y));
                }
            }
        }
    }
}
