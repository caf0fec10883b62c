//! What a search saves.

/// What a search saves, of a frame or of the units.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Price {
    /// Nanoseconds of a frame.
    Time,
    /// Millijoules of a frame, by the whole system.
    Energy,
    /// Square millimetres of both units' cells.
    Area,
}

impl Price {
    /// Of time in nanoseconds, energy in millijoules and area in square millimetres its own, where
    /// that is known.
    #[must_use]
    pub fn of(self, [time, energy, area]: [Option<f64>; 3]) -> Option<f64> {
        match self {
            Self::Time => time,
            Self::Energy => energy,
            Self::Area => area,
        }
    }

    /// A cost with its unit.
    #[must_use]
    pub fn words(self, cost: f64) -> String {
        match self {
            Self::Time => format!("{:.3} ms a frame", cost * 1e-6),
            Self::Energy => format!("{cost:.3} mJ a frame"),
            Self::Area => format!("{cost:.4} mm^2"),
        }
    }
}
