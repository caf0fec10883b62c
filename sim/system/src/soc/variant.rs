//! What is set side by side: which frames are rendered in full, and what gathers.

use serde::Serialize;

/// Which frames of a path are rendered, and how.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Frames {
    /// Each in full.
    Full,
    /// Warped from references (SpaRW).
    Warped,
    /// Each warped from the one before (Temp-N).
    Chained,
    /// At half the resolution, scaled up (DS-2).
    Half,
}

/// What gathers features, and in which order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Gathering {
    /// The GPU, pixel by pixel.
    PixelOrder,
    /// The GPU, `MVoxel` by `MVoxel` (fully streaming).
    Streamed,
    /// The gathering unit, `MVoxel` by `MVoxel`.
    Unit,
}

/// A variant of the system (paper, Sec. "Variants"), each optimisation alone, and what the paper
/// compares quality with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Variant {
    /// As it is called on the command line.
    pub name: &'static str,
    /// Which frames are rendered.
    pub frames: Frames,
    /// What gathers.
    pub gathering: Gathering,
}

impl Variant {
    /// All of them; speed-ups are over the first.
    pub const ALL: [Self; 8] = [
        Self::new("baseline", Frames::Full, Gathering::PixelOrder),
        Self::new("fs", Frames::Full, Gathering::Streamed),
        Self::new("fs+gu", Frames::Full, Gathering::Unit),
        Self::new("sparw", Frames::Warped, Gathering::PixelOrder),
        Self::new("sparw+fs", Frames::Warped, Gathering::Streamed),
        Self::new("potamoi", Frames::Warped, Gathering::Unit),
        Self::new("ds2", Frames::Half, Gathering::PixelOrder),
        Self::new("temp", Frames::Chained, Gathering::PixelOrder),
    ];

    const fn new(name: &'static str, frames: Frames, gathering: Gathering) -> Self {
        Self {
            name,
            frames,
            gathering,
        }
    }

    /// By its name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|own| own.name == name)
    }
}

/// Where full frames are rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Scenario {
    /// Here.
    Local,
    /// By a machine at the other end of a link: of the baseline all frames, of warped ones
    /// their references.
    Remote,
}
