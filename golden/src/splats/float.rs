//! The float renderer: the reference that fixed-point pictures are held to.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::cloud::Cloud;
use super::error::RenderError;
use super::frame::Decisions;
use super::profile::Profile;
use super::project::Projected;
use super::view::{TILE, TILE_PIXELS, View};
use crate::camera::Camera;
use crate::picture::Picture;

/// How to render.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct FloatOptions {
    /// Linear RGB behind everything.
    pub background: [f32; 3],
    /// Whether to keep [`FloatFrame::decisions`].
    pub log_decisions: bool,
}

/// Counts of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FloatStats {
    /// Gaussians that the near plane culled.
    pub culled: u64,
    /// Gaussians that touch a tile.
    pub visible: u64,
    /// (tile, Gaussian) pairs.
    pub entries: u64,
    /// (pixel, entry) pairs whose exponential was taken: those of pixels that
    /// had not stopped.
    pub exponentials: u64,
    /// (pixel, entry) pairs that were added to a pixel.
    pub drawn: u64,
    /// Pixels that stopped early.
    pub stopped: u64,
}

/// A rendered frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FloatFrame {
    /// The picture, background included.
    pub picture: Picture,
    /// Transmittance left at each pixel, 1 where nothing was drawn.
    pub transmittance: Vec<f64>,
    /// Counts.
    pub stats: FloatStats,
    /// Each skip and stop, where asked for.
    pub decisions: Option<Decisions>,
}

/// One tile, as its thread leaves it.
struct TileResult {
    colour: [DVec3; TILE_PIXELS],
    transmittance: [f64; TILE_PIXELS],
    stop: [u32; TILE_PIXELS],
    drawn: Vec<[u64; TILE_PIXELS / 64]>,
    exponentials: u64,
    draws: u64,
}

/// Renders in 64-bit floats, tile by tile. The result does not depend on the
/// number of threads, nor on the order of the Gaussians in the cloud.
///
/// # Errors
/// As [`View::new`].
pub fn render_float(
    cloud: &Cloud,
    camera: &Camera,
    profile: Profile,
    options: &FloatOptions,
) -> Result<FloatFrame, RenderError> {
    let view = View::new(cloud, camera, profile)?;
    Ok(render_view(&view, options))
}

pub(crate) fn render_view(view: &View, options: &FloatOptions) -> FloatFrame {
    let (first, ranks) = view.by_tile();
    let tiles: Vec<TileResult> = (0..view.tile_count())
        .into_par_iter()
        .map(|t| {
            let list = &ranks[first[t]..first[t + 1]];
            render_tile(view, t, list, options.log_decisions)
        })
        .collect();

    let [width, height] = view.size();
    let background = DVec3::from(options.background.map(f64::from));
    let mut picture = Picture::filled(width, height, options.background);
    let mut transmittance = vec![1.0; picture.rgb.len()];
    let mut stats = FloatStats {
        culled: view.culled() as u64,
        visible: view.splats().len() as u64,
        entries: view.entries() as u64,
        ..FloatStats::default()
    };
    let mut decisions = options.log_decisions.then(|| Decisions::new(first.clone()));
    for (t, tile) in tiles.iter().enumerate() {
        let [[x0, y0], [columns, rows]] = view.tile_pixels(t);
        for y in 0..rows {
            for x in 0..columns {
                let from = (y * TILE + x) as usize;
                let to = (y0 + y) as usize * width as usize + (x0 + x) as usize;
                let colour = tile.colour[from] + tile.transmittance[from] * background;
                picture.rgb[to] = colour.as_vec3().to_array();
                transmittance[to] = tile.transmittance[from];
            }
        }
        stats.exponentials += tile.exponentials;
        stats.drawn += tile.draws;
        stats.stopped += tile.stop.iter().filter(|s| **s != u32::MAX).count() as u64;
        if let Some(d) = &mut decisions {
            d.stop[t] = tile.stop;
            d.drawn[first[t]..first[t + 1]].copy_from_slice(&tile.drawn);
        }
    }
    FloatFrame {
        picture,
        transmittance,
        stats,
        decisions,
    }
}

fn render_tile(view: &View, tile: usize, ranks: &[u32], log: bool) -> TileResult {
    let rules = view.rules();
    let [[x0, y0], [columns, rows]] = view.tile_pixels(tile);
    let mut out = TileResult {
        colour: [DVec3::ZERO; TILE_PIXELS],
        transmittance: [1.0; TILE_PIXELS],
        stop: [u32::MAX; TILE_PIXELS],
        drawn: vec![[0; TILE_PIXELS / 64]; if log { ranks.len() } else { 0 }],
        exponentials: 0,
        draws: 0,
    };
    let mut live: Vec<usize> = (0..rows)
        .flat_map(|y| (0..columns).map(move |x| (y * TILE + x) as usize))
        .collect();
    let origin = DVec2::new(f64::from(x0), f64::from(y0)) + rules.pixel_centre;
    for (entry, rank) in ranks.iter().enumerate() {
        if live.is_empty() {
            break;
        }
        let splat: &Projected = &view.splats()[*rank as usize];
        out.exponentials += live.len() as u64;
        live.retain(|&pixel| {
            let (x, y) = (pixel % TILE as usize, pixel / TILE as usize);
            let offset = origin + DVec2::new(x as f64, y as f64) - splat.mean;
            let alpha = splat.alpha(offset).min(rules.alpha_cap);
            if alpha < rules.alpha_min {
                return true;
            }
            let before = out.transmittance[pixel];
            let after = before * (1.0 - alpha);
            if rules.stops(after) {
                out.stop[pixel] = entry as u32;
                return false;
            }
            out.colour[pixel] += splat.colour * (alpha * before);
            out.transmittance[pixel] = after;
            out.draws += 1;
            if log {
                out.drawn[entry][pixel / 64] |= 1 << (pixel % 64);
            }
            true
        });
    }
    out
}
