//! Structural similarity (Wang, Bovik, Sheikh and Simoncelli 2004).

use rayon::prelude::*;

use crate::picture::Picture;

/// Standard deviation of the Gaussian window, in pixels.
const SIGMA: f64 = 1.5;
/// Taps on either side: 11 in all.
const RADIUS: usize = 5;
/// `(0.01 L)^2` and `(0.03 L)^2`, with a peak L of 1.
const C1: f64 = 1e-4;
const C2: f64 = 9e-4;

/// Mean structural similarity of two pictures of equal size, with peak 1, over the pixels that
/// `counts` selects and whose whole 11 x 11 window lies within the picture, with equal weight for
/// all channels; `None` if there are none.
#[must_use]
pub fn ssim(a: &Picture, b: &Picture, counts: impl Fn(usize) -> bool) -> Option<f64> {
    let (width, height) = (a.width as usize, a.height as usize);
    let same = (a.width, a.height) == (b.width, b.height);
    if !same || width <= 2 * RADIUS || height <= 2 * RADIUS {
        return None;
    }
    let channels: Vec<Vec<f64>> = (0..3).into_par_iter().map(|c| map(a, b, c)).collect();
    let (mut sum, mut pixels) = (0.0, 0usize);
    for y in RADIUS..height - RADIUS {
        for x in RADIUS..width - RADIUS {
            if counts(y * width + x) {
                pixels += 1;
                sum += channels.iter().map(|c| c[y * width + x]).sum::<f64>();
            }
        }
    }
    (pixels > 0).then(|| sum / (3 * pixels) as f64)
}

/// The similarity of one channel at each pixel with a complete window.
fn map(a: &Picture, b: &Picture, channel: usize) -> Vec<f64> {
    let (width, height) = (a.width as usize, a.height as usize);
    let plane = |f: &dyn Fn(f64, f64) -> f64| -> Vec<f64> {
        let pairs = a.rgb.iter().zip(&b.rgb);
        let values = pairs.map(|(a, b)| f(f64::from(a[channel]), f64::from(b[channel])));
        smooth(&values.collect::<Vec<_>>(), width, height)
    };
    let mean_a = plane(&|a, _| a);
    let mean_b = plane(&|_, b| b);
    let square_a = plane(&|a, _| a * a);
    let square_b = plane(&|_, b| b * b);
    let product = plane(&|a, b| a * b);
    (0..width * height)
        .map(|i| {
            let (ma, mb) = (mean_a[i], mean_b[i]);
            let variance = (square_a[i] - ma * ma) + (square_b[i] - mb * mb);
            let covariance = product[i] - ma * mb;
            (2.0 * ma * mb + C1) * (2.0 * covariance + C2)
                / ((ma * ma + mb * mb + C1) * (variance + C2))
        })
        .collect()
}

/// Gaussian mean along rows, then columns; 0 where the window is incomplete.
fn smooth(values: &[f64], width: usize, height: usize) -> Vec<f64> {
    let weights: [f64; 2 * RADIUS + 1] = std::array::from_fn(|k| {
        let d = k as f64 - RADIUS as f64;
        (-0.5 * d * d / (SIGMA * SIGMA)).exp()
    });
    let total: f64 = weights.iter().sum();
    let mut rows = vec![0.0; values.len()];
    for (to, from) in rows.chunks_exact_mut(width).zip(values.chunks_exact(width)) {
        for x in RADIUS..width - RADIUS {
            let window = &from[x - RADIUS..=x + RADIUS];
            let sum: f64 = weights.iter().zip(window).map(|(w, v)| w * v).sum();
            to[x] = sum / total;
        }
    }
    let mut all = vec![0.0; values.len()];
    for y in RADIUS..height - RADIUS {
        for x in RADIUS..width - RADIUS {
            let column = (y - RADIUS..=y + RADIUS).map(|line| rows[line * width + x]);
            let sum: f64 = weights.iter().zip(column).map(|(w, v)| w * v).sum();
            all[y * width + x] = sum / total;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use serde::Deserialize;

    #[derive(Deserialize)]
    struct Case {
        width: u32,
        height: u32,
        a: Vec<u8>,
        b: Vec<u8>,
        ssim: f64,
    }

    /// Recorded by tools/warp-fixtures.
    const FIXTURES: &str = include_str!("../../tests/fixtures/ssim.json");

    fn picture(width: u32, height: u32, codes: &[u8]) -> Picture {
        let pixels = codes.as_chunks::<3>().0.iter();
        Picture {
            width,
            height,
            rgb: pixels.map(|p| p.map(|v| f32::from(v) / 255.0)).collect(),
        }
    }

    #[test]
    fn it_is_scikit_images() {
        let cases: Vec<Case> = serde_json::from_str(FIXTURES).unwrap();
        assert!(cases.len() >= 12);
        for case in &cases {
            let [a, b] = [&case.a, &case.b].map(|codes| picture(case.width, case.height, codes));
            let found = ssim(&a, &b, |_| true).unwrap();
            // Pixels are rounded to 24 bits here, which a flat window of small
            // variance sees most.
            assert!((found - case.ssim).abs() < 1e-5, "{found} {}", case.ssim);
        }
    }

    #[test]
    fn pixels_are_picked_and_small_pictures_have_none() {
        let a = Picture::filled(30, 20, [0.5; 3]);
        let mut b = a.clone();
        for y in 0..20 {
            b.rgb[y * 30] = [0.9, 0.1, 0.3];
        }
        // The fault is within the window of the sixth column, not of the next.
        assert!(ssim(&a, &b, |i| i % 30 == 5).unwrap() < 0.99);
        assert!((ssim(&a, &b, |i| i % 30 > 5).unwrap() - 1.0).abs() < 1e-12);
        assert!(ssim(&a, &b, |i| i % 30 < 5).is_none());
        let tiny = Picture::filled(10, 40, [0.5; 3]);
        assert!(ssim(&tiny, &tiny, |_| true).is_none());
        assert!(ssim(&a, &tiny, |_| true).is_none());
    }
}
