//! Variants of the system: which frames are rendered in full, and how features are gathered.

use schemars::JsonSchema;
use serde::Serialize;

/// How the frames of a path are rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
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

/// Where features are gathered, and in which order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Gathering {
    /// On the GPU in pixel-centric order.
    PixelOrder,
    /// On the GPU in memory-centric order, `MVoxel` by `MVoxel` (fully streaming).
    Streamed,
    /// On the gathering unit in memory-centric order, `MVoxel` by `MVoxel`.
    Unit,
}

/// A variant of the system (paper, Sec. "Variants"): each optimisation alone, and the baselines of
/// the paper's quality comparison.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
pub struct Variant {
    /// Name on the command line.
    pub name: &'static str,
    /// How frames are rendered.
    pub frames: Frames,
    /// How features are gathered.
    pub gathering: Gathering,
}

impl Variant {
    /// All variants; speed-ups are over the first.
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

    /// The variant of this name, if any.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|own| own.name == name)
    }
}

/// Where full frames are rendered.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Scenario {
    /// On the device.
    Local,
    /// On a remote machine at the other end of the link: all frames of the baseline, references of
    /// warped paths.
    Remote,
}

impl Scenario {
    /// Heading of a table.
    #[must_use]
    pub const fn heading(self) -> &'static str {
        match self {
            Self::Local => "Local rendering",
            Self::Remote => "Remote rendering",
        }
    }
}
