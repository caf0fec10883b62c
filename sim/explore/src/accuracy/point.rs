//! Measurements of a setting.

use potamoi_system::system_model::ClockOrigin;
use schemars::JsonSchema;
use serde::Serialize;

use super::image_quality::{ImageQuality, PixelError};
use super::pareto_front::CostQuality;
use super::price::Price;
use super::units::UnitErrors;

/// Measurements of a setting.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct Point {
    /// Name of the knob; `default` and `found` belong to none.
    pub knob: String,
    /// Label of the setting.
    pub setting: String,
    /// Errors of the units' operations.
    pub units: UnitErrors,
    /// Quality against the ground truth that the model was sampled from, where it is known.
    pub truth: Option<ImageQuality>,
    /// Quality against the converged picture of the model.
    pub converged: ImageQuality,
    /// Quality against the same picture in floating point: the error of the hardware's formats
    /// alone. `None` where settings change that picture, and for path variants.
    pub float: Option<ImageQuality>,
    /// Largest error of a pixel's channel against floating point; `None` where settings change what
    /// no bound covers, and for path variants.
    pub worst: Option<PixelError>,
    /// Cycles of the gathering unit for a full frame.
    pub gather_cycles: u64,
    /// Cycles of the vector unit for a full frame.
    pub vector_cycles: u64,
    /// Cycles of the MAC array for a full frame.
    pub array_cycles: u64,
    /// Clock of the accelerator in gigahertz.
    pub clock_ghz: f64,
    /// Origin of that clock.
    pub clock_origin: ClockOrigin,
    /// Nanoseconds of a frame among many like it; for a path variant the mean.
    pub frame_ns: f64,
    /// Millijoules of a frame; `None` where no formulas cover the units.
    pub energy_mj: Option<f64>,
    /// Cell area of the units at 12 nm, in square millimetres; `None` where no formulas cover them.
    pub area_mm2: Option<f64>,
    /// Whether settings change a unit, so that area, energy and clock are the default's with the change that
    /// formulas give.
    pub is_estimated: bool,
}

impl Point {
    /// Quality and time.
    #[must_use]
    pub fn place(&self) -> CostQuality {
        place(self.converged, self.truth, self.frame_ns)
    }

    /// Quality and another cost; `None` where that is not known.
    #[must_use]
    pub(crate) fn priced(&self, price: Price) -> Option<CostQuality> {
        let costs = [Some(self.frame_ns), self.energy_mj, self.area_mm2];
        priced(self.converged, self.truth, costs, price)
    }
}

/// Quality against the ground truth where it is known, else against the converged picture. Equal
/// pictures have infinite quality.
fn place(converged: ImageQuality, truth: Option<ImageQuality>, cost: f64) -> CostQuality {
    CostQuality {
        cost,
        quality: truth.unwrap_or(converged).db.unwrap_or(f64::INFINITY),
    }
}

/// [`place`] by time, energy or area; `None` where that is not known.
pub(super) fn priced(
    converged: ImageQuality,
    truth: Option<ImageQuality>,
    costs: [Option<f64>; 3],
    price: Price,
) -> Option<CostQuality> {
    price.of(costs).map(|cost| place(converged, truth, cost))
}
