//! Transmittance and colour of a tile's pixels, and what a pair of pixel and Gaussian changes.

use super::{TILE, TILE_PIXELS};
use crate::splat_unit::ROW_MASK;

/// Transmittance 1, U1.20.
const CLEAR: u32 = 1 << 20;
/// Alpha 1, U0.16.
const FULL: u32 = 1 << 16;

/// Thresholds of a set of rules, as codes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize)]
pub struct Thresholds {
    /// Cap of alpha, U0.16.
    pub alpha_cap: u32,
    /// Smaller alphas are skipped.
    pub alpha_min: u32,
    /// A pixel stops where `T (65536 - alpha)`, 36 fraction bits, is below this.
    pub stop: u64,
    /// Low bits of the transmittance that are not carried.
    pub spare: u32,
}

/// What becomes of a pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Its alpha is below the threshold, or the pixel has stopped.
    Skipped,
    /// It contributes to the pixel.
    Drawn,
    /// The pixel stops; the pair does not contribute.
    Stopped,
}

/// The pixels of a tile.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TileState {
    /// Pixels that have not stopped, row by row, the first pixel lowest.
    pub live: [u16; TILE as usize],
    /// Transmittance per pixel, U1.20.
    pub transmittance: [u32; TILE_PIXELS],
    /// Colour per pixel, 32 fraction bits; below 16.
    pub colour: [[u64; 3]; TILE_PIXELS],
}

impl TileState {
    /// A tile on which nothing has been drawn.
    pub const CLEAR: Self = Self {
        live: [ROW_MASK; TILE as usize],
        transmittance: [CLEAR; TILE_PIXELS],
        colour: [[0; 3]; TILE_PIXELS],
    };

    /// Composites a pair: pixel `16 y + x`, the product of opacity and power, U0.16, and the
    /// Gaussian's colour, U4.12.
    pub fn composite(
        &mut self,
        pixel: usize,
        alpha: u32,
        colour: [u16; 3],
        thresholds: &Thresholds,
    ) -> Outcome {
        let (row, column) = (pixel / TILE as usize, pixel % TILE as usize);
        let alpha = alpha.min(thresholds.alpha_cap);
        if alpha < thresholds.alpha_min || self.live[row] >> column & 1 == 0 {
            return Outcome::Skipped;
        }
        let before = self.transmittance[pixel];
        let product = u64::from(before) * u64::from(FULL - alpha);
        if product < thresholds.stop {
            self.live[row] &= !(1 << column);
            return Outcome::Stopped;
        }
        let bits = 16 + thresholds.spare;
        let after = ((product + (1 << (bits - 1))) >> bits) as u32;
        let after = (after << thresholds.spare).min(before);
        self.transmittance[pixel] = after;
        let weight = u64::from(before - after);
        for (sum, channel) in self.colour[pixel].iter_mut().zip(colour) {
            *sum += weight * u64::from(channel);
        }
        Outcome::Drawn
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const INRIA: Thresholds = Thresholds {
        alpha_cap: 64_881,
        alpha_min: 258,
        stop: 6_871_948,
        spare: 0,
    };

    #[test]
    fn a_pixel_stops_by_the_exact_product_and_stays_as_it_is() {
        let mut tile = TileState::CLEAR;
        let cap = |tile: &mut TileState| tile.composite(5, 65_535, [4096, 0, 65_535], &INRIA);
        assert_eq!(cap(&mut tile), Outcome::Drawn);
        let once = tile.clone();
        // Two samples at the cap leave slightly less than 1e-4.
        assert_eq!(cap(&mut tile), Outcome::Stopped);
        assert_eq!(
            (tile.transmittance, tile.colour),
            (once.transmittance, once.colour)
        );
        assert_eq!(tile.live[0], ROW_MASK & !(1 << 5));
        assert_eq!(cap(&mut tile), Outcome::Skipped);
        let weight = u64::from(CLEAR - once.transmittance[5]);
        assert_eq!(once.colour[5], [weight << 12, 0, weight * 65_535]);
    }

    #[test]
    fn alphas_below_the_threshold_change_nothing() {
        let mut tile = TileState::CLEAR;
        assert_eq!(tile.composite(0, 257, [1; 3], &INRIA), Outcome::Skipped);
        assert_eq!(tile, TileState::CLEAR);
        assert_eq!(tile.composite(0, 258, [1; 3], &INRIA), Outcome::Drawn);
    }
}
