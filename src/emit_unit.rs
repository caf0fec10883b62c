//! The units that `emit` writes.

use clap::ValueEnum;
use potamoi_formats::config::ExpForm;

use crate::suggest;

/// Units to write.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub(crate) enum EmitUnit {
    /// The gathering unit
    Gu,
    /// The vector unit
    Vu,
    /// The gathering and the vector unit, the SoC top that joins them, and the splat unit if there is one
    Both,
    /// The exponential by itself: one operand in, one power out
    Exp,
    /// The splat unit, of a configuration with a table [su]
    Su,
}

impl EmitUnit {
    pub(crate) const fn has(self, unit: Self) -> bool {
        matches!(self, Self::Both) || self as u8 == unit as u8
    }
}

/// A form by its name on the command line.
pub(crate) fn form(name: &str) -> Result<ExpForm, String> {
    let mut all = ExpForm::ALL.iter();
    all.find(|form| form.name() == name)
        .copied()
        .ok_or_else(|| {
            let names: Vec<_> = ExpForm::ALL.iter().map(|form| form.name()).collect();
            let expected = format!("expected one of {}", names.join(", "));
            suggest::with_nearest(expected, name, names)
        })
}
