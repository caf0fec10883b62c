//! Linear RGB pictures, their differences, and PNG files.

use std::path::{Path, PathBuf};

use image::codecs::png::PngEncoder;
use image::{ExtendedColorType, ImageEncoder as _};
use thiserror::Error;

use crate::files;

/// A picture in linear RGB, unquantised.
#[derive(Debug, Clone, PartialEq)]
pub struct Picture {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Red, green, blue, row by row from the top left.
    pub rgb: Vec<[f32; 3]>,
}

/// A picture cannot be written.
#[derive(Debug, Error)]
pub enum PictureError {
    /// The file system or the encoder returned an error.
    #[error("cannot write picture {path}: {source}; name a folder that exists and is writable")]
    Write {
        /// The file.
        path: PathBuf,
        /// The error.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

impl Picture {
    /// A picture of one colour.
    #[must_use]
    pub fn filled(width: u32, height: u32, colour: [f32; 3]) -> Self {
        Self {
            width,
            height,
            rgb: vec![colour; width as usize * height as usize],
        }
    }

    /// Mean squared error over the pixels that `counts` selects, with equal weight for all
    /// channels; `None` if there are none or the sizes differ.
    #[must_use]
    pub fn mean_squared_error(&self, other: &Self, counts: impl Fn(usize) -> bool) -> Option<f64> {
        if (self.width, self.height) != (other.width, other.height) {
            return None;
        }
        let mut sum = 0.0;
        let mut pixels = 0usize;
        for (i, (a, b)) in self.rgb.iter().zip(&other.rgb).enumerate() {
            if counts(i) {
                pixels += 1;
                for (x, y) in a.iter().zip(b) {
                    sum += (f64::from(*x) - f64::from(*y)).powi(2);
                }
            }
        }
        (pixels > 0).then(|| sum / (3 * pixels) as f64)
    }

    /// Peak signal-to-noise ratio in dB against `other`, with peak 1, unquantised; infinite for
    /// equal pictures.
    #[must_use]
    pub fn psnr(&self, other: &Self, counts: impl Fn(usize) -> bool) -> Option<f64> {
        self.mean_squared_error(other, counts)
            .map(|mse| -10.0 * mse.log10())
    }

    /// Writes an 8-bit PNG. Values are clamped to 0..1 and rounded without a transfer curve, since
    /// radiance fields are trained on display values.
    ///
    /// # Errors
    /// The folder does not exist or cannot be written.
    pub fn write_png(&self, path: &Path) -> Result<(), PictureError> {
        let fail = |source: Box<dyn std::error::Error + Send + Sync>| PictureError::Write {
            path: path.to_owned(),
            source,
        };
        let bytes: Vec<u8> = self
            .rgb
            .iter()
            .flatten()
            // Rounded half up, exact in 64 bits: the cast cuts off.
            .map(|v| (f64::from(v.clamp(0.0, 1.0) * 255.0) + 0.5) as u8)
            .collect();
        let mut png = vec![];
        // The encoder by its name: choosing it by a format builds those of all formats.
        PngEncoder::new(&mut png)
            .write_image(&bytes, self.width, self.height, ExtendedColorType::Rgb8)
            .map_err(|e| fail(e.into()))?;
        files::write(path, &png).map_err(|e| fail(e.into()))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn psnr_is_ten_decibels_a_decade_of_squared_error() {
        let black = Picture::filled(4, 2, [0.0; 3]);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-5, "{a} {b}");
        for (off, decibels) in [(0.1, 20.0), (0.01, 40.0), (1.0, 0.0), (0.5, 6.020_599_9)] {
            let other = Picture::filled(4, 2, [off; 3]);
            close(black.psnr(&other, |_| true).unwrap(), decibels);
        }
        // One channel of three, in one pixel of eight, of which a quarter counts.
        let mut spot = black.clone();
        spot.rgb[5] = [0.0, 0.3, 0.0];
        close(
            black.mean_squared_error(&spot, |_| true).unwrap(),
            0.09 / 24.0,
        );
        let counts = |i| i == 5 || i == 6;
        close(black.mean_squared_error(&spot, counts).unwrap(), 0.09 / 6.0);
        assert_eq!(black.psnr(&black, |_| true), Some(f64::INFINITY));
        assert_eq!(black.psnr(&spot, |_| false), None);
        assert_eq!(black.psnr(&Picture::filled(2, 4, [0.0; 3]), |_| true), None);
    }
}
