//! Jobs of the splat unit: what goes in, and what comes out.

use potamoi_formats::config::SplatOpacity;
use potamoi_formats::record::SplatRecord;

use super::tile_state::{Thresholds, TileState};

/// A record in a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct SplatEntry {
    /// The tile's number in the unit.
    pub slot: u16,
    /// The tile's column and row in the picture.
    pub tile: [u16; 2],
    /// The last column and row of the tile that lie in the picture, 0 to 15.
    pub last: [u8; 2],
    /// The record.
    pub record: SplatRecord,
}

/// Settings of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct SplatSettings {
    /// Thresholds of the rules.
    pub thresholds: Thresholds,
    /// Whether pixel centres lie at half a pixel, not at 0.
    pub is_centred: bool,
    /// How opacities enter alphas, which records are made for.
    pub opacity: SplatOpacity,
}

/// Work of the unit.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, serde::Serialize)]
pub struct SplatUnitCounts {
    /// Square sums, one for each pair of pixel and Gaussian in a span.
    pub square_sums: u64,
    /// Exponentials, one for each pair that the cut by stored limits keeps.
    pub exponentials: u64,
    /// Of those, the pairs within the exact limit of their opacity. Of an exponential that never rises
    /// these are the pairs that draw or stop a pixel.
    pub within_exact_limit: u64,
    /// Pairs that contribute to a pixel.
    pub drawn: u64,
    /// Pairs at which a pixel terminates early.
    pub stopped: u64,
}

impl std::ops::AddAssign for SplatUnitCounts {
    fn add_assign(&mut self, other: Self) {
        self.square_sums += other.square_sums;
        self.exponentials += other.exponentials;
        self.within_exact_limit += other.within_exact_limit;
        self.drawn += other.drawn;
        self.stopped += other.stopped;
    }
}

/// A job: the entries of a ray group, and the tiles whose pixels are returned.
#[derive(Debug, Clone, Copy)]
pub struct SplatJob<'j> {
    /// Settings of the frame.
    pub settings: SplatSettings,
    /// Number of tiles, slots 0 to `tiles - 1`; at least 1, and at most those that the unit holds.
    pub tiles: usize,
    /// Records in tiles, those of a tile in the order of compositing.
    pub entries: &'j [SplatEntry],
}

/// A pixel that the unit returns.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SplatPixel {
    /// Final transmittance, U1.20.
    pub transmittance: u32,
    /// Colour sums, 32 fraction bits, below 16.
    pub colour: [u64; 3],
}

impl SplatPixel {
    /// The pixels of tiles, row by row.
    pub fn of_tiles(tiles: &[TileState]) -> impl Iterator<Item = Self> {
        tiles.iter().flat_map(|tile| {
            let both = tile.transmittance.iter().zip(tile.colour);
            both.map(|(transmittance, colour)| Self {
                transmittance: *transmittance,
                colour,
            })
        })
    }
}

/// Results of a job.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Composited {
    /// The pixels of all tiles of the job, tile by tile and row by row: 256 a tile, those beyond the
    /// picture included.
    pub pixels: Vec<SplatPixel>,
    /// Work of the unit.
    pub counts: SplatUnitCounts,
}
