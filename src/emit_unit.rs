//! The units that `emit` writes.

use clap::ValueEnum;

/// Units to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum EmitUnit {
    /// The gathering unit
    Gu,
    /// The vector unit
    Vu,
    /// Both units
    Both,
}

impl EmitUnit {
    pub(crate) const fn has(self, unit: Self) -> bool {
        matches!(self, Self::Both) || self as u8 == unit as u8
    }
}
