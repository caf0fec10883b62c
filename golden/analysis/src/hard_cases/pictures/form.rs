//! Obvious forms of the renderer.

/// How the obvious form goes about it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Form {
    /// The equations as they stand, in 32-bit floats without any guard.
    Float32,
    /// The same, of the file in reverse.
    Reversed,
    /// The same with 16 fraction bits of transmittance, cut off.
    Transmittance16,
    /// The same, nothing added to the covariance on screen.
    Undilated,
}

impl Form {
    /// In words.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::Float32 => "32-bit floats, no guards",
            Self::Reversed => "ties as the file has them",
            Self::Transmittance16 => "transmittance in U0.16, cut off",
            Self::Undilated => "32-bit floats, the covariance as projected",
        }
    }
}
