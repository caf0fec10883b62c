//! Largest differences and values of a grid, of which bounds of errors are made.

use super::formats::Formats;
use super::grid::Grid;

/// Largest differences and values within a grid, by channel.
#[derive(Debug)]
pub(super) struct Ranges {
    /// Between vertices of a cell.
    cell: Vec<f64>,
    /// Between neighbours along each axis, summed over axes.
    slope: Vec<f64>,
    /// Largest magnitude.
    pub(super) largest: Vec<f64>,
    /// Whether a value is below 0.
    pub(super) is_negative: Vec<bool>,
}

impl Ranges {
    pub(super) fn new(grid: &Grid) -> Self {
        let (points, channels) = (grid.points(), grid.layout().channels());
        let at = |x: usize, y: usize, z: usize, c: usize| {
            let vertex = x + points[0] * (y + points[1] * z);
            f64::from(grid.features()[vertex * channels + c])
        };
        let mut ranges = Self {
            cell: vec![0.0; channels],
            slope: vec![0.0; channels],
            largest: vec![0.0; channels],
            is_negative: vec![false; channels],
        };
        for vertex in grid.features().chunks_exact(channels) {
            for (c, value) in vertex.iter().enumerate() {
                ranges.largest[c] = ranges.largest[c].max(f64::from(value.abs()));
                ranges.is_negative[c] |= *value < 0.0;
            }
        }
        for c in 0..channels {
            let mut slope = [0f64; 3];
            for z in 0..points[2] - 1 {
                for y in 0..points[1] - 1 {
                    for x in 0..points[0] - 1 {
                        let corner = |i: usize| at(x + (i & 1), y + (i >> 1 & 1), z + (i >> 2), c);
                        let all = [0, 1, 2, 3, 4, 5, 6, 7].map(corner);
                        let high = all.into_iter().fold(f64::MIN, f64::max);
                        let low = all.into_iter().fold(f64::MAX, f64::min);
                        ranges.cell[c] = ranges.cell[c].max(high - low);
                        for (axis, slope) in slope.iter_mut().enumerate() {
                            for i in (0..8).filter(|i| i >> axis & 1 == 0) {
                                *slope = slope.max((all[i | 1 << axis] - all[i]).abs());
                            }
                        }
                    }
                }
            }
            ranges.slope[c] = slope.iter().sum();
        }
        ranges
    }

    /// Upper bound of a gathered feature's error.
    pub(super) fn off(&self, formats: &Formats, channel: usize) -> f64 {
        let format = match channel {
            0 => formats.density,
            _ => formats.colour,
        };
        let unit = 2f64.powi(-(formats.weight_bits as i32));
        format.ulp() + 3.5 * unit * self.cell[channel] + 2f64.powi(-13) * self.slope[channel]
    }
}
