//! How colours are taken from a reference.

use serde::Serialize;

/// How colours are taken from a reference.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Sampling {
    /// Of the point that landed on the pixel, as the paper has it. It lies up to
    /// half a pixel off the pixel's centre.
    Nearest,
    /// Where the point that the pixel's centre shows is in the reference,
    /// bilinearly between neighbours of the same surface.
    Bilinear,
}
