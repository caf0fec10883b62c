//! Image quality and pixel errors.

use potamoi_base::picture::Picture;
use potamoi_base::ssim::ssim;
use serde::Serialize;

/// Quality of a picture against a reference picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct ImageQuality {
    /// PSNR in dB, from the mean squared error over all pixels, peak 1; `None` where pictures are
    /// equal.
    pub db: Option<f64>,
    /// SSIM; `None` for pictures smaller than 11 x 11 pixels.
    pub ssim: Option<f64>,
}

impl ImageQuality {
    pub(super) fn of(shown: &Picture, other: &Picture) -> Self {
        Self {
            db: shown.psnr(other, |_| true).filter(|db| db.is_finite()),
            ssim: ssim(shown, other, |_| true),
        }
    }

    /// Quality of a path's frames against the model. `of` is measured in floating point; the
    /// squared error of the hardware's formats, from a full frame, is added.
    pub(super) fn path(of: [Option<f64>; 2], formats: Self) -> Self {
        let error = |db: Option<f64>| db.map_or(0.0, |db| 10f64.powf(-0.1 * db));
        let sum = error(of[0]) + error(formats.db);
        Self {
            db: (sum > 0.0).then(|| -10.0 * sum.log10()),
            ssim: of[1].zip(formats.ssim).map(|(own, formats)| own * formats),
        }
    }

    /// Shifts the quality of a full frame by the difference between a path's frames (`of`) and the
    /// same path in full (`full`).
    pub(super) fn moved(self, of: [Option<f64>; 2], full: [Option<f64>; 2]) -> Self {
        let moved = |own: Option<f64>, i: usize| Some(own? + of[i]? - full[i]?);
        Self {
            db: moved(self.db, 0),
            ssim: moved(self.ssim, 1),
        }
    }
}

/// Errors of pixels against the float model, with their bounds.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct PixelError {
    /// Largest error of a channel, peak 1.
    pub measured: f64,
    /// Largest bound by error analysis; `None` where none is derived, or where settings change the
    /// float model.
    pub bound: Option<f64>,
    /// Largest ratio of a pixel's error to its own bound.
    pub part_of_bound: Option<f64>,
    /// PSNR in dB if all pixels were at their bounds.
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
