//! Sampling of colours in a reference.

use serde::Serialize;

/// Sampling of colours in a reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sampling {
    /// The colour of the point that landed on the pixel, as in the paper. It is up to half a pixel
    /// off the pixel's centre.
    Nearest,
    /// The colour at the reference position of the point seen at the pixel's centre, bilinear
    /// between neighbours on the same surface.
    Bilinear,
}
