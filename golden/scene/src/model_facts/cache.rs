//! Facts about a model, computed once, since models do not change.

use std::fmt;
use std::sync::{Arc, OnceLock};

use super::ModelFacts;

/// Rows of an MVoxel and halvings of its cells, with the numbers of MVoxels before and after
/// merging.
type Merging = ((usize, u32), [usize; 2]);

/// Cached facts. Clones share them. A cache depends only on the model, so any two compare equal.
#[derive(Clone, Default)]
pub(crate) struct Cache {
    facts: Arc<OnceLock<ModelFacts>>,
    merging: Arc<OnceLock<Merging>>,
    content: Arc<OnceLock<blake3::Hash>>,
}

impl Cache {
    pub(crate) fn facts(&self, find: impl FnOnce() -> ModelFacts) -> &ModelFacts {
        self.facts.get_or_init(find)
    }

    /// Whether the facts are known.
    pub(crate) fn has_facts(&self) -> bool {
        self.facts.get().is_some()
    }

    /// The hash of all of the model's numbers.
    pub(crate) fn content(&self, find: impl FnOnce() -> blake3::Hash) -> blake3::Hash {
        *self.content.get_or_init(find)
    }

    /// Numbers of MVoxels before and after merging, for given rows and halvings. Only the first
    /// combination is cached.
    pub(crate) fn merging(&self, of: (usize, u32), find: impl Fn() -> [usize; 2]) -> [usize; 2] {
        let (known, found) = *self.merging.get_or_init(|| (of, find()));
        if known == of { found } else { find() }
    }
}

impl PartialEq for Cache {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl fmt::Debug for Cache {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Cache")
    }
}
