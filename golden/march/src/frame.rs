//! Frames in the hardware's formats: pixels over a background.

use potamoi_base::mask::Mask;
use potamoi_base::picture::Picture;
use potamoi_formats::fixed::{Format, Rounding};

use crate::compositor::Compositor;
use crate::counts::FixedStats;
use crate::error::MarchError;
use crate::transmittance::TRANSMITTANCE;

/// Format of the background.
pub const BACKGROUND: Format = Format::signed(3, 12);
/// Fraction bits of a finished pixel.
const PIXEL_BITS: u32 = 32;

/// A rendered frame.
#[derive(Debug, Clone, PartialEq)]
pub struct FixedFrame {
    /// The picture, including the background.
    pub picture: Picture,
    /// Final transmittance per pixel, U1.20 codes.
    pub transmittance: Vec<u32>,
    /// Samples per pixel that are gathered up to where the ray terminates early; `u32::MAX` where
    /// it does not. Independent of ray groups, batches and halo.
    pub stops: Vec<u32>,
    /// Work and traffic.
    pub stats: FixedStats,
}

impl FixedFrame {
    /// An empty frame of this size: black pixels, transmittance 0, no work.
    pub fn clear([width, height]: [u32; 2]) -> Self {
        let pixels = width as usize * height as usize;
        Self {
            picture: Picture::filled(width, height, [0.0; 3]),
            transmittance: vec![0; pixels],
            stops: vec![u32::MAX; pixels],
            stats: FixedStats::default(),
        }
    }

    /// Replaces the pixels outside a mask by the background.
    pub fn leave_out(&mut self, only: Option<&Mask>, background: [f32; 3]) {
        let Some(mask) = only else { return };
        let unit = 2f64.powi(-(BACKGROUND.frac_bits() as i32));
        let behind = background_codes(background).map(|code| (code as f64 * unit) as f32);
        for (i, colour) in self.picture.rgb.iter_mut().enumerate() {
            if !mask.has(i) {
                *colour = behind;
                self.transmittance[i] = 1 << TRANSMITTANCE.frac_bits();
            }
        }
    }
}

/// Checks that the pixel sums can represent a background.
pub fn check_background(background: [f32; 3]) -> Result<(), MarchError> {
    let fits = |v: &f32| v.is_finite() && v.abs() < 8.0;
    if background.iter().all(fits) {
        return Ok(());
    }
    Err(MarchError::Option {
        field: "background",
        value: format!("{background:?}"),
        expected: "finite numbers below 8",
    })
}

fn background_codes(background: [f32; 3]) -> [i64; 3] {
    background.map(|v| {
        let code = BACKGROUND.quantise(f64::from(v), Rounding::HalfEven);
        code.unwrap_or_default() as i64
    })
}

/// Writes composited rays to their pixels, over a background.
pub fn place(
    frame: &mut FixedFrame,
    pixels: &[[u32; 2]],
    done: &Compositor<'_>,
    background: [f32; 3],
) {
    let background = background_codes(background);
    let up = PIXEL_BITS - done.pixel_bits();
    let behind_up = PIXEL_BITS - BACKGROUND.frac_bits() - TRANSMITTANCE.frac_bits();
    for (slot, [x, y]) in pixels.iter().enumerate() {
        let to = (y * frame.picture.width + x) as usize;
        let left = done.transmittance[slot];
        // Never negative, at most 1.
        frame.transmittance[to] = left as u32;
        frame.stops[to] = done.stops[slot];
        for c in 0..3 {
            let behind = (i64::from(left) * background[c]) << behind_up;
            let sum = (done.sums[slot][c] << up) + behind;
            frame.picture.rgb[to][c] = (sum as f64 * 2f64.powi(-(PIXEL_BITS as i32))) as f32;
        }
    }
}
