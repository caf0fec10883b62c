//! What was found of a setting.

use serde::Serialize;

use super::front::Place;
use super::likeness::{Likeness, PixelError};
use super::price::Price;
use super::units::UnitErrors;

/// What was found of a setting.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Point {
    /// The knob's name; `default` and `found` are of no knob.
    pub knob: String,
    /// The setting's label.
    pub setting: String,
    /// What the operations of the units are off by.
    pub units: UnitErrors,
    /// Beside the float model.
    pub model: Likeness,
    /// Beside what the model was sampled from, where that is known.
    pub truth: Option<Likeness>,
    /// Largest error of a channel of a pixel beside the float model; not measured over paths.
    pub worst: Option<PixelError>,
    /// Cycles of the gathering unit, of a frame in full.
    pub gather_cycles: u64,
    /// Cycles of the vector unit, likewise.
    pub vector_cycles: u64,
    /// Cycles of the MAC array, likewise.
    pub array_cycles: u64,
    /// Nanoseconds of a frame, of a path its mean.
    pub frame_ns: f64,
    /// Millijoules of a frame; none where no formulas are of the units.
    pub energy_mj: Option<f64>,
    /// Square millimetres of both units' cells at 12 nm, by formulas; likewise.
    pub area_mm2: Option<f64>,
}

impl Point {
    /// Its quality and its time.
    #[must_use]
    pub fn place(&self) -> Place {
        place(self.model, self.truth, self.frame_ns)
    }

    /// Its quality and another cost than time; none where that is not known.
    #[must_use]
    pub fn priced(&self, price: Price) -> Option<Place> {
        let costs = [Some(self.frame_ns), self.energy_mj, self.area_mm2];
        priced(self.model, self.truth, costs, price)
    }
}

/// Quality beside the truth where that is known, else beside the model. Equal pictures are
/// as good as any.
fn place(model: Likeness, truth: Option<Likeness>, cost: f64) -> Place {
    Place {
        cost,
        quality: truth.unwrap_or(model).db.unwrap_or(f64::INFINITY),
    }
}

/// [`place`] by one of time, energy and area, where that is known.
pub(super) fn priced(
    model: Likeness,
    truth: Option<Likeness>,
    costs: [Option<f64>; 3],
    price: Price,
) -> Option<Place> {
    price.of(costs).map(|cost| place(model, truth, cost))
}
