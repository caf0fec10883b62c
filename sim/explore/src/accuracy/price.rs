//! Cost that a search minimises.

/// Cost that a search minimises.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Price {
    /// Time of a frame in nanoseconds.
    Time,
    /// Energy of a frame in the whole system, in millijoules.
    Energy,
    /// Cell area of both units in square millimetres.
    Area,
}

impl Price {
    /// Selects this cost from time in nanoseconds, energy in millijoules and area in square
    /// millimetres.
    #[must_use]
    pub fn of(self, [time, energy, area]: [Option<f64>; 3]) -> Option<f64> {
        match self {
            Self::Time => time,
            Self::Energy => energy,
            Self::Area => area,
        }
    }

    /// Formats a cost with its unit.
    #[must_use]
    pub fn words(self, cost: f64) -> String {
        match self {
            Self::Time => format!("{:.3} ms a frame", cost * 1e-6),
            Self::Energy => format!("{cost:.3} mJ a frame"),
            Self::Area => format!("{cost:.4} mm^2"),
        }
    }
}
