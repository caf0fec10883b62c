//! Syntheses that a user gives beside those that come with the program.

use std::path::PathBuf;
use std::sync::Arc;

use potamoi_base::content_hash::hash_of;
use potamoi_synth::Synthesised;

use crate::ExploreError;

/// Synthesised units of any configurations. The first that has a unit counts, before those that come with
/// the program.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Syntheses {
    all: Arc<[Synthesised]>,
    identity: Option<blake3::Hash>,
}

impl Syntheses {
    /// Reads files that `potamoi synth --json` wrote.
    ///
    /// # Errors
    /// As [`Synthesised::read`].
    pub fn read(paths: &[PathBuf]) -> Result<Self, ExploreError> {
        let all: Result<Vec<Synthesised>, _> =
            paths.iter().map(|path| Synthesised::read(path)).collect();
        Ok(Self::of(all?))
    }

    /// These syntheses.
    #[must_use]
    pub fn of(all: Vec<Synthesised>) -> Self {
        let reports: Vec<_> = all.iter().map(|own| &own.report).collect();
        Self {
            identity: (!all.is_empty()).then(|| hash_of(&reports)),
            all: all.into(),
        }
    }

    /// The syntheses in their order.
    #[must_use]
    pub fn all(&self) -> &[Synthesised] {
        &self.all
    }

    /// What figures depend on; none without syntheses.
    #[must_use]
    pub const fn identity(&self) -> Option<blake3::Hash> {
        self.identity
    }
}
