//! Figures of a report by unit and memory.

use crate::report::{ScaledMemory, ScaledUnit};
use crate::{MemoryReport, SynthReport, UnitKind, UnitReport};

impl SynthReport {
    /// A unit at the library's node.
    #[must_use]
    pub fn unit(&self, unit: UnitKind) -> Option<&UnitReport> {
        self.raw.units.iter().find(|u| u.unit == unit.top())
    }

    /// A unit at the node that the file is scaled to.
    #[must_use]
    pub fn scaled_unit(&self, unit: UnitKind) -> Option<&ScaledUnit> {
        let logic = self.scaled.as_ref()?.logic.as_ref()?;
        logic.units.iter().find(|u| u.unit == unit.top())
    }

    /// A memory at the node of its model, and at the node that the file is scaled to.
    #[must_use]
    pub fn memory(&self, of: &str, name: &str) -> Option<(&MemoryReport, Option<&ScaledMemory>)> {
        let macros = &self.raw.memories.as_ref()?.macros;
        let at = macros.iter().position(|m| m.of == of && m.memory == name)?;
        let scaled = self.scaled.as_ref().and_then(|s| s.memories.as_ref());
        Some((&macros[at], scaled.and_then(|s| s.macros.get(at))))
    }
}
