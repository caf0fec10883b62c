//! What pixels need of a projected Gaussian, and the tiles that it can reach.

use rayon::prelude::*;

use crate::coverage::{Grid, Span};
use crate::profile::Rules;
use crate::project::Projected;
use crate::view::View;
use potamoi_reference::splat_unit::TILE;

/// Gaussians whose data lie together, a power of two.
pub(super) const CHUNK: usize = 1 << 12;

/// What pixels need of a projected Gaussian: 72 bytes in 64-bit floats, and two words.
#[derive(Debug, Clone, Copy)]
pub(super) struct Splat {
    /// Mean in pixels.
    pub(super) mean: [f64; 2],
    /// L11, L21, L22 of [`Footprint::factor`](crate::Footprint::factor).
    pub(super) factor: [f64; 3],
    pub(super) opacity: f64,
    /// Linear RGB.
    pub(super) colour: [f64; 3],
    /// An upper bound of the squared distance `p^2 + q^2` at which alpha is at the threshold.
    pub(super) reach: f32,
    /// Index of the Gaussian in the cloud.
    pub(super) index: u32,
}

/// An upper bound of the squared distance at which alpha falls to the alpha threshold; `None` if it
/// is below it everywhere.
pub(super) fn reach(splat: &Projected, rules: &Rules) -> Option<f64> {
    let ratio = splat.opacity / rules.alpha_min;
    // Wider than rounding, here and in the pixels, can tell.
    let squared = 2.0 * ratio.ln() + 1e-6;
    // Of an opacity that is no number nothing is left out.
    if squared < 0.0 { None } else { Some(squared) }
}

impl Splat {
    /// The data of a Gaussian of this reach.
    pub(super) fn new(splat: &Projected, reach: f64) -> Self {
        Self {
            mean: splat.mean.to_array(),
            factor: splat.footprint.factor,
            opacity: splat.opacity,
            colour: splat.colour.to_array(),
            // A unit of the last place up, whichever way it was rounded.
            reach: (reach as f32).next_up(),
            index: splat.index as u32,
        }
    }
}

/// The tiles with a pixel that a Gaussian of this reach can reach.
pub(super) fn reached(splat: &Projected, reach: f64, grid: Grid, rules: &Rules) -> Span {
    let [xx, _, yy] = splat.footprint.covariance;
    let last = f64::from(TILE - 1);
    let of = |mean: f64, variance: f64, tiles: u32| {
        let half = (variance * reach).sqrt();
        // Of pixel centres, and wider than rounding can tell.
        let slack = 0.01 + 1e-6 * (mean.abs() + half);
        let middle = mean - rules.pixel_centre;
        let from = (middle - half - slack - last) / f64::from(TILE);
        let to = (middle + half + slack) / f64::from(TILE);
        // Casts saturate, and NaN becomes 0: a NaN reach leaves no tile out.
        let to = if to.is_nan() { f64::INFINITY } else { to };
        if to < 0.0 {
            return [0, 0];
        }
        [
            (from.ceil() as u32).min(tiles),
            (to as u32).saturating_add(1).min(tiles),
        ]
    };
    let mean = splat.mean.to_array();
    Span {
        x: of(mean[0], xx, grid.columns),
        y: of(mean[1], yy, grid.rows),
    }
}

/// Data of all Gaussians that can reach a pixel, in chunks of at most [`CHUNK`].
pub(super) struct Splats(pub(super) Vec<Vec<Splat>>);

impl Splats {
    /// The Gaussians of a view: slots are ranks.
    pub(super) fn of_view(view: &View) -> Self {
        let data = |splat| Splat::new(splat, reach(splat, view.rules()).unwrap_or(f64::NAN));
        let chunks = view.splats().par_chunks(CHUNK);
        Self(chunks.map(|own| own.iter().map(data).collect()).collect())
    }

    /// The Gaussian in a slot: its chunk, times [`CHUNK`], and its place there.
    #[inline(always)]
    pub(super) fn at(&self, slot: u32) -> &Splat {
        &self.0[slot as usize / CHUNK][slot as usize % CHUNK]
    }
}

/// View depths of a view's Gaussians, in chunks as [`Splats`].
pub(super) fn depths_of_view(view: &View) -> Vec<Vec<f64>> {
    let chunks = view.splats().chunks(CHUNK);
    let depths = chunks.map(|own| own.iter().map(|splat| splat.depth).collect());
    depths.collect()
}
