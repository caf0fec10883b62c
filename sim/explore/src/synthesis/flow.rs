//! What units are synthesised with.

use std::path::Path;

use potamoi_formats::config::Config;
use potamoi_synth::{Library, Made, SynthError, Tools, UnitKind, synthesise};

/// What units are synthesised with.
#[derive(Clone, Copy)]
pub struct Flow<'a> {
    /// The cells.
    pub library: &'a Library,
    /// Yosys and OpenSTA.
    pub tools: &'a Tools,
    /// Where results are kept.
    pub cache: &'a Path,
}

impl Flow<'_> {
    /// Synthesises a unit; `step` is called after each step, as [`synthesise`] has them.
    ///
    /// # Errors
    /// As [`synthesise`].
    pub fn synthesise(
        &self,
        config: &Config,
        unit: UnitKind,
        step: &dyn Fn(),
    ) -> Result<Made, SynthError> {
        synthesise(config, unit, self.library, self.tools, self.cache, step)
    }
}
