//! Parameters of a frame.

use potamoi_base::mask::Mask;

/// Parameters of a frame.
#[derive(Debug, Clone, Copy)]
pub struct Setup<'a> {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Side of a ray group in pixels, at least 1; by default the largest with at most
    /// [`crate::GROUP_RAYS`] rays.
    pub side: Option<u32>,
    /// Pixels to render, the others being background; by default all.
    pub only: Option<&'a Mask>,
    /// Early-termination threshold (transmittance); by default no ray stops early.
    pub stop: Option<f64>,
    /// Fraction bits of the transmittance carried from sample to sample, at most 20.
    pub transmittance_bits: u32,
    /// Background, linear RGB.
    pub background: [f32; 3],
}
