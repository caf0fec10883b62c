//! The Gaussians of a cloud as pixels need them, in the cloud's order.

use rayon::prelude::*;

use super::splats::{CHUNK, Splat, Splats, reach, reached};
use crate::coverage::{self, Grid, Span};
use crate::project::Projection;
use potamoi_gaussians::Cloud;

/// Gaussians that can reach a pixel of a tile that they are drawn in.
pub(super) struct Prepared {
    pub(super) splats: Splats,
    /// View depth of each Gaussian, in chunks as `splats`.
    pub(super) depths: Vec<Vec<f64>>,
    /// First column and row of tiles of each Gaussian, and one past the last.
    pub(super) tiles: Vec<Vec<[u16; 4]>>,
    /// (tile, Gaussian) pairs of the profile's rule.
    pub(super) pairs: u64,
}

struct Chunk {
    splats: Vec<Splat>,
    depths: Vec<f64>,
    tiles: Vec<[u16; 4]>,
    pairs: u64,
}

impl Prepared {
    /// Projects every Gaussian once, and keeps those that can reach a pixel. The rule of tiles must be
    /// one of rectangles.
    pub(super) fn new(cloud: &Cloud, projection: &Projection<'_>, grid: Grid) -> Self {
        let chunks: Vec<Chunk> = (0..cloud.len().div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                let first = chunk * CHUNK;
                of_range(projection, grid, first..cloud.len().min(first + CHUNK))
            })
            .collect();
        let mut all = Self {
            splats: Splats(Vec::with_capacity(chunks.len())),
            depths: Vec::with_capacity(chunks.len()),
            tiles: Vec::with_capacity(chunks.len()),
            pairs: 0,
        };
        for chunk in chunks {
            all.splats.0.push(chunk.splats);
            all.depths.push(chunk.depths);
            all.tiles.push(chunk.tiles);
            all.pairs += chunk.pairs;
        }
        all
    }
}

fn of_range(projection: &Projection<'_>, grid: Grid, range: std::ops::Range<usize>) -> Chunk {
    let rules = projection.rules();
    let mut chunk = Chunk {
        // Memory that is never written is never taken.
        splats: Vec::with_capacity(range.len()),
        depths: Vec::with_capacity(range.len()),
        tiles: Vec::with_capacity(range.len()),
        pairs: 0,
    };
    for index in range {
        if !rules.sees(projection.depth(index)) {
            continue;
        }
        let splat = projection.project(index);
        let Some(span) = coverage::rectangle(&splat, grid, rules) else {
            continue;
        };
        chunk.pairs += span.count();
        let Some(reach) = reach(&splat, rules) else {
            continue;
        };
        let Span { x, y } = span.within(&reached(&splat, reach, grid, rules));
        if x[0] >= x[1] || y[0] >= y[1] {
            continue;
        }
        chunk.splats.push(Splat::new(&splat, reach));
        chunk.depths.push(splat.depth);
        chunk.tiles.push([x[0], y[0], x[1], y[1]].map(|v| v as u16));
    }
    chunk
}
