//! Kinds of operation built by a configuration.

use potamoi_formats::config::Config;
use potamoi_formats::units::OpCode;

/// Kinds of operation built by a configuration.
#[derive(Debug, Clone, Copy)]
pub(super) struct OperationKinds {
    /// Any operation of the engine.
    pub(super) exp: bool,
    pub(super) one_minus: bool,
    pub(super) elementwise: bool,
    pub(super) sigmoid: bool,
    pub(super) softplus: bool,
}

impl OperationKinds {
    pub(super) fn of(config: &Config) -> Self {
        let ops = &config.vu.ops;
        Self {
            exp: ops.iter().any(|o| o.is_exponential()),
            one_minus: ops.contains(&OpCode::OneMinusExp),
            elementwise: ops.iter().any(|o| !o.is_exponential()),
            sigmoid: ops.contains(&OpCode::Sigmoid),
            softplus: ops.contains(&OpCode::Softplus),
        }
    }

    /// Whether operations of more than one pass are built.
    pub(super) const fn logistic(self) -> bool {
        self.sigmoid || self.softplus
    }
}
