//! Centres wider than 32-bit floats.
//!
//! The subtracted origin is a median, so that a few outliers do not decide where the others are
//! rounded.

use glam::DVec3;

/// Ratio of the distance from the world's origin to that from their median, from which on most
/// centres count as far off.
const FAR: f64 = 32.0;
/// Rounding error of a centre, as a fraction of its Gaussian's size, above which it is reported.
const MATTERS: f64 = 1.0 / 256.0;

/// Centres as stored, and the largest size of each Gaussian.
pub(super) struct Centres<'a> {
    pub(super) wide: &'a [[f64; 3]],
    pub(super) log_scales: &'a [[f32; 3]],
}

/// Centres whose rounding error is reported.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rounded {
    /// Number of centres.
    pub(super) count: usize,
    /// Largest rounding error along an axis.
    pub(super) most: f64,
}

impl Centres<'_> {
    /// The origin subtracted along each axis before centres are rounded to 32 bits: the float
    /// nearest to their median if most of them are far off, or if fewer would be rounded
    /// noticeably with it; otherwise 0. It is a float, so that differences are exact.
    pub(super) fn origin(&self) -> DVec3 {
        DVec3::from([0, 1, 2].map(|axis| {
            let all = || self.wide.iter().map(|own| own[axis]);
            if all().all(|v| v == f64::from(v as f32)) {
                return 0.0;
            }
            let middle = f64::from(median(all()) as f32);
            let spread = median(all().map(|v| (v - middle).abs()));
            let is_far = middle.abs() > FAR * spread;
            match is_far || self.moved(axis, middle).count() < self.moved(axis, 0.0).count() {
                true => middle,
                false => 0.0,
            }
        }))
    }

    /// The centres that are still rounded after an origin is subtracted.
    pub(super) fn rounded(&self, origin: DVec3) -> Option<Rounded> {
        let mut moved = vec![0.0f64; self.wide.len()];
        for axis in 0..3 {
            for (at, by) in self.moved(axis, origin[axis]) {
                moved[at] = moved[at].max(by);
            }
        }
        let count = moved.iter().filter(|by| **by > 0.0).count();
        let most = moved.into_iter().fold(0.0, f64::max);
        (count > 0).then_some(Rounded { count, most })
    }

    /// Centres whose rounding error is noticeable against their Gaussians' sizes, with the error.
    /// Gaussians of size 0 never count.
    fn moved(&self, axis: usize, origin: f64) -> impl Iterator<Item = (usize, f64)> {
        let both = self.wide.iter().zip(self.log_scales).enumerate();
        both.filter_map(move |(at, (own, scales))| {
            let size = scales.map(|s| f64::from(s).exp()).into_iter();
            let size = size.fold(0.0, f64::max);
            let value = own[axis] - origin;
            let by = (value - f64::from(value as f32)).abs();
            (size > f64::from(f32::MIN_POSITIVE) * 2.0 && by > MATTERS * size).then_some((at, by))
        })
    }
}

/// The median of values; the upper one of an even number.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut all: Vec<f64> = values.collect();
    if all.is_empty() {
        return 0.0;
    }
    let at = all.len() / 2;
    *all.select_nth_unstable_by(at, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn origin(wide: &[[f64; 3]]) -> [f64; 3] {
        let log_scales = vec![[0.05f32.ln(); 3]; wide.len()];
        let centres = Centres {
            wide,
            log_scales: &log_scales,
        };
        centres.origin().to_array()
    }

    #[test]
    fn centres_are_brought_back_only_where_floats_would_move_them() {
        let near = [[0.1, -0.2, 0.3], [-0.7, 0.9, -1.1]];
        assert_eq!(origin(&near), [0.0; 3]);
        let utm = near.map(|[x, y, z]| [x + 500_000.0, y, z]);
        let found = origin(&utm);
        assert_eq!(found[1..], [0.0; 2]);
        assert!((found[0] - 500_000.0).abs() < 1.0 && found[0] == f64::from(found[0] as f32));
        // What floats hold stays where it is, however far.
        assert_eq!(origin(&[[5e5, 1.0, 2.0], [500_000.5, 1.5, 2.0]]), [0.0; 3]);
    }

    #[test]
    fn one_centre_far_from_the_others_decides_nothing_and_is_told() {
        let mut wide: Vec<[f64; 3]> = (0..9)
            .map(|i| {
                [
                    500_000.1 + 0.1 * f64::from(i),
                    5_400_000.3,
                    0.1 * f64::from(i),
                ]
            })
            .collect();
        for outlier in [0.0, 400_000.7, -1e9 / 3.0] {
            wide.push([outlier, outlier, 0.1]);
            let found = origin(&wide);
            assert!((found[0] - 500_000.5).abs() < 1.0, "{outlier}");
            assert!((found[1] - 5_400_000.3).abs() < 1.0, "{outlier}");
            assert_eq!(found[2], 0.0);
            let log_scales = vec![[0.05f32.ln(), -20.0, -20.0]; wide.len()];
            let centres = Centres {
                wide: &wide,
                log_scales: &log_scales,
            };
            let rounded = centres.rounded(DVec3::from(found));
            // A difference of two floats that is one itself is not rounded.
            assert_eq!(rounded.is_some(), outlier != 0.0, "{outlier}: {rounded:?}");
            if let Some(rounded) = rounded {
                assert!(rounded.count == 1 && rounded.most > 1e-4, "{rounded:?}");
            }
            wide.pop();
        }
    }

    /// Neither far by their spread, nor right as they are.
    #[test]
    fn a_wide_place_is_brought_back_where_that_moves_fewer() {
        let wide: Vec<[f64; 3]> = (0..101)
            .map(|i| [300_000.1 + 4_000.3 * f64::from(i), 0.0, 0.0])
            .collect();
        assert!(origin(&wide)[0] > 400_000.0);
    }
}
