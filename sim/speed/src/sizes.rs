//! Sizes of the work that is measured.

use potamoi_formats::config::Config;

/// Sizes of all sections.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sizes {
    /// Multiplications and additions of vectors in a run of the peak.
    pub(crate) peak_rounds: u64,
    /// Runs of the peak.
    pub(crate) peak_runs: u32,
    /// Pixels of `dense` on a side.
    pub(crate) dense: u32,
    /// Pixels of the garden on a side.
    pub(crate) garden: u32,
    /// Pixels of fields on a side.
    pub(crate) fields: u32,
    /// Pixels on a side of the frame whose work stimulates the units.
    pub(crate) units: u32,
    /// Entries of the gathering unit's stimulus, and elements of the vector unit's.
    pub(crate) stimulus: [u64; 2],
    /// Pixels on a side of the frame that is verified.
    pub(crate) verify: u32,
    /// Configuration of the units.
    pub(crate) config: fn() -> Config,
}

impl Sizes {
    /// Those of the command.
    pub(crate) const FULL: Self = Self {
        peak_rounds: 600_000_000,
        peak_runs: 5,
        dense: 400,
        garden: 800,
        fields: 200,
        units: 200,
        stimulus: [4_000, 40_000],
        verify: 64,
        config: Config::paper,
    };
}
