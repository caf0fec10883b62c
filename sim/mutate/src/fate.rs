//! What becomes of a mutant.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Miter;

/// What becomes of a mutant.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case", tag = "fate")]
pub enum Fate {
    /// The bench finds it.
    Bench {
        /// The run of the bench: gaps and seed.
        run: String,
        /// What the bench says.
        said: String,
    },
    /// It is equivalent.
    Equivalent {
        /// As the miter shows.
        miter: Miter,
    },
    /// The verification finds it.
    Verify {
        /// The difference.
        said: String,
    },
    /// Properties that are proven of the unit are not of the mutant.
    Proofs {
        /// Their names.
        properties: Vec<String>,
    },
    /// No judge finds it.
    Alive,
}
