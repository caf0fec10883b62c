//! How like pictures are, and what their pixels are off by.

use potamoi_base::picture::Picture;
use potamoi_base::ssim::ssim;
use serde::Serialize;

/// How like a picture is to another.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Likeness {
    /// Decibels of the mean squared error, peak 1, over all pixels; none where they are equal.
    pub db: Option<f64>,
    /// Structural similarity, in pictures of 11 x 11 pixels or more.
    pub ssim: Option<f64>,
}

impl Likeness {
    pub(super) fn of(shown: &Picture, other: &Picture) -> Self {
        Self {
            db: shown.psnr(other, |_| true).filter(|db| db.is_finite()),
            ssim: ssim(shown, other, |_| true),
        }
    }

    /// Of a path's frames beside the model's, compared in floating point, as the hardware's formats
    /// show them: squared errors of the formats, on a frame in full, come to those of the path.
    pub(super) fn path(of: [Option<f64>; 2], formats: Self) -> Self {
        let error = |db: Option<f64>| db.map_or(0.0, |db| 10f64.powf(-0.1 * db));
        let sum = error(of[0]) + error(formats.db);
        Self {
            db: (sum > 0.0).then(|| -10.0 * sum.log10()),
            ssim: of[1].zip(formats.ssim).map(|(own, formats)| own * formats),
        }
    }

    /// Of a frame in full, by as much more or less as a path's frames are beside it than the same
    /// path's in full.
    pub(super) fn moved(self, of: [Option<f64>; 2], full: [Option<f64>; 2]) -> Self {
        let moved = |own: Option<f64>, i: usize| Some(own? + of[i]? - full[i]?);
        Self {
            db: moved(self.db, 0),
            ssim: moved(self.ssim, 1),
        }
    }
}

/// Errors of a picture's pixels beside the float model's, and what they cannot exceed.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PixelError {
    /// The largest of a channel.
    pub measured: f64,
    /// The largest bound, by analysis; none where none is derived, or where the scene is not
    /// rendered as the float model is.
    pub bound: Option<f64>,
    /// The largest part of its own bound that a pixel takes.
    pub part_of_bound: Option<f64>,
    /// Decibels that all pixels at their bounds would have.
    pub bound_db: Option<f64>,
}

impl PixelError {
    pub(super) fn new(shown: &Picture, model: &Picture, bounds: Option<&[f64]>) -> Self {
        let off: Vec<f64> = (shown.rgb.iter().zip(&model.rgb))
            .map(|(a, b)| {
                let channels = a.iter().zip(b);
                channels.fold(0.0, |m, (a, b)| {
                    f64::max(m, (f64::from(*a) - f64::from(*b)).abs())
                })
            })
            .collect();
        let most = |all: &[f64]| all.iter().copied().fold(0.0, f64::max);
        let part = |bounds: &[f64]| {
            off.iter()
                .zip(bounds)
                .map(|(o, b)| o / b)
                .fold(0.0, f64::max)
        };
        let mean =
            |bounds: &[f64]| bounds.iter().map(|b| b * b).sum::<f64>() / bounds.len().max(1) as f64;
        Self {
            measured: most(&off),
            bound: bounds.map(most),
            part_of_bound: bounds.map(part),
            bound_db: bounds.map(|b| -10.0 * mean(b).log10()),
        }
    }
}
