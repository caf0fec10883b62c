//! The float renderer: the reference that fixed-point pictures are held to.

use glam::DVec3;
use rayon::prelude::*;

use super::cloud::Cloud;
use super::error::RenderError;
use super::frame::Decisions;
use super::profile::Profile;
use super::tile::{Canvas, Tile, TileLog};
use super::view::{TILE, View};
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
    /// (pixel, entry) pairs of pixels that had not stopped: the exponentials
    /// that the hardware takes.
    pub exponentials: u64,
    /// Those that were evaluated here: what lies beyond the ellipse of the
    /// faintest alpha that counts is skipped, but for the rest of a group of
    /// four pixels.
    pub evaluated: u64,
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
    let canvas = Canvas::new(view);
    let [width, height] = view.size();
    let [columns, _] = view.grid();
    let background = DVec3::from(options.background.map(f64::from));
    let mut picture = Picture::filled(width, height, [0.0; 3]);
    let mut transmittance = vec![1.0; picture.rgb.len()];
    let mut decisions = options
        .log_decisions
        .then(|| Decisions::new(first.clone()));

    // Bands of one tile's height: each thread writes pixels of its own.
    let band = TILE as usize * width as usize;
    let bands: Vec<Vec<TileLog>> = picture
        .rgb
        .par_chunks_mut(band)
        .zip(transmittance.par_chunks_mut(band))
        .enumerate()
        .map(|(row, (rgb, left))| {
            let tiles: Vec<Tile> = (row * columns as usize..(row + 1) * columns as usize)
                .into_par_iter()
                .map(|t| canvas.render(t, &ranks[first[t]..first[t + 1]], options.log_decisions))
                .collect();
            for (column, tile) in tiles.iter().enumerate() {
                let t = row * columns as usize + column;
                let [[x0, _], [wide, high]] = view.tile_pixels(t);
                for y in 0..high as usize {
                    let at = y * width as usize + x0 as usize;
                    for x in 0..wide as usize {
                        let from = y * TILE as usize + x;
                        let colour = tile.colour(from) + tile.left[from] * background;
                        rgb[at + x] = colour.as_vec3().to_array();
                        left[at + x] = tile.left[from];
                    }
                }
            }
            tiles.into_iter().map(|t| t.log).collect()
        })
        .collect();

    let mut stats = FloatStats {
        culled: view.culled() as u64,
        visible: view.splats().len() as u64,
        entries: view.entries() as u64,
        ..FloatStats::default()
    };
    for (t, log) in bands.into_iter().flatten().enumerate() {
        stats.exponentials += log.live;
        stats.evaluated += log.evaluated;
        stats.drawn += log.draws;
        stats.stopped += log.stopped;
        if let (Some(d), Some((drawn, stop))) = (&mut decisions, log.decisions) {
            d.stop[t] = stop;
            d.drawn[first[t]..first[t + 1]].copy_from_slice(&drawn);
        }
    }
    FloatFrame {
        picture,
        transmittance,
        stats,
        decisions,
    }
}
