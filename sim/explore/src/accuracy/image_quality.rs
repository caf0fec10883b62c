//! Image quality and pixel errors.

use potamoi_base::picture::Picture;
use potamoi_base::ssim::ssim;
use schemars::JsonSchema;
use serde::Serialize;

/// Quality of a picture against a reference picture.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct ImageQuality {
    /// PSNR in dB, from the mean squared error over all pixels, peak 1; `None` where pictures are
    /// equal.
    pub db: Option<f64>,
    /// SSIM; `None` for pictures smaller than 11 x 11 pixels.
    pub ssim: Option<f64>,
}

impl ImageQuality {
    /// Quality of `shown` against `other`, over all pixels.
    #[must_use]
    pub fn of(shown: &Picture, other: &Picture) -> Self {
        Self {
            db: shown.psnr(other, |_| true).filter(|db| db.is_finite()),
            ssim: ssim(shown, other, |_| true),
        }
    }

    /// Quality of a path's frames against converged ones. `of` is that of frames in floating point
    /// against full frames with the same settings; the squared error of a full frame in the
    /// hardware's formats (`full`) is added.
    pub(super) fn path(of: [Option<f64>; 2], full: Self) -> Self {
        let error = |db: f64| 10f64.powf(-0.1 * db);
        Self {
            // Equal frames have no error.
            db: match (of[0], full.db) {
                (Some(own), Some(full)) => Some(-10.0 * (error(own) + error(full)).log10()),
                (own, full) => own.or(full),
            },
            ssim: of[1].zip(full.ssim).map(|(own, full)| own * full),
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

/// Errors of pixels against the picture in floating point, with their bounds: those of the
/// hardware's formats alone.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct PixelError {
    /// Largest error of a channel, peak 1.
    pub measured: f64,
    /// Largest bound by error analysis; `None` where none is derived.
    pub bound: Option<f64>,
    /// Largest ratio of a pixel's error to its own bound.
    pub part_of_bound: Option<f64>,
    /// PSNR in dB if all pixels were at their bounds.
    pub bound_db: Option<f64>,
}

impl PixelError {
    pub(super) fn new(shown: &Picture, float: &Picture, bounds: Option<&[f64]>) -> Self {
        let off: Vec<f64> = (shown.rgb.iter().zip(&float.rgb))
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
