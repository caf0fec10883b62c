//! Configuration of the vector unit.

use serde::{Deserialize, Serialize};

use super::ExpConfig;
use crate::units::OpCode;

/// The vector unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VuConfig {
    /// Number of lanes. The paper states none; 24, one for each MAC column, is a named assumption.
    pub lanes: u32,
    /// Operations built; by default all but sigmoid and softplus.
    pub ops: Vec<OpCode>,
    /// Capacity of the output FIFO in results.
    pub fifo_depth: u32,
    /// The exponential engine.
    pub exp: ExpConfig,
}

impl Default for VuConfig {
    fn default() -> Self {
        Self {
            lanes: 24,
            ops: OpCode::ALL
                .into_iter()
                .filter(|op| !op.is_logistic())
                .collect(),
            fifo_depth: 3,
            exp: ExpConfig::default(),
        }
    }
}
