//! Library, tools and cache of syntheses.

use std::path::Path;

use potamoi_formats::config::Config;
use potamoi_synth::{Library, SynthError, SynthesisedUnit, Tools, UnitKind, synthesise};

/// Library, tools and cache of syntheses.
#[derive(Clone, Copy)]
pub struct Flow<'a> {
    /// Standard cells.
    pub library: &'a Library,
    /// Yosys and OpenSTA.
    pub tools: &'a Tools,
    /// Folder of cached results.
    pub cache: &'a Path,
}

impl Flow<'_> {
    /// Synthesises a unit; `step` is called after each step of [`synthesise`].
    ///
    /// # Errors
    /// As [`synthesise`].
    pub fn synthesise(
        &self,
        config: &Config,
        unit: UnitKind,
        step: &dyn Fn(),
    ) -> Result<SynthesisedUnit, SynthError> {
        synthesise(config, unit, self.library, self.tools, self.cache, step)
    }
}
