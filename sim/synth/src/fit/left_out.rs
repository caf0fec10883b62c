//! Cross-validation: errors at points left out of the fit.

use schemars::JsonSchema;
use serde::Serialize;

use super::estimate::{Estimate, Work};
use super::formulas::Formulas;
use crate::SynthError;
use crate::grid::{Family, GridPoint};

/// Relative errors of one figure over points left out one at a time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, JsonSchema)]
pub struct Spread {
    /// Number of points.
    pub points: usize,
    /// Root mean square.
    pub rms: f64,
    /// Largest magnitude.
    pub worst: f64,
}

/// Relative errors at one point that was left out of the fit.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PointErrors {
    /// Its differences from the defaults.
    pub point: String,
    /// Area.
    pub area: f64,
    /// Longest path.
    pub period: f64,
    /// Energy a cycle with zero delays.
    pub zero_delay: f64,
    /// Energy a cycle with glitches.
    pub with_glitches: f64,
    /// Leakage.
    pub leakage: f64,
}

/// Relative errors of a family.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct LeftOut {
    /// Errors by point.
    pub points: Vec<PointErrors>,
    /// Area.
    pub area: Spread,
    /// Longest path.
    pub period: Spread,
    /// Energy a cycle with zero delays.
    pub zero_delay: Spread,
    /// Energy a cycle with glitches.
    pub with_glitches: Spread,
    /// Leakage.
    pub leakage: Spread,
}

impl PointErrors {
    pub(super) fn new(point: &GridPoint, found: &Estimate) -> Self {
        let [zero_delay, with_glitches] = point.energy();
        let leakage: f64 = point.modules.iter().map(|m| m.energy.leakage_nw).sum();
        Self {
            point: point.name(),
            area: found.area_um2 / point.area_um2() - 1.0,
            period: found.period_ps / point.period_ps - 1.0,
            zero_delay: found.zero_delay_pj / zero_delay - 1.0,
            with_glitches: found.with_glitches_pj / with_glitches - 1.0,
            leakage: found.leakage_nw / leakage - 1.0,
        }
    }
}

impl Spread {
    pub(super) fn new(errors: impl Iterator<Item = f64>) -> Self {
        let errors: Vec<_> = errors.collect();
        let squares: f64 = errors.iter().map(|e| e * e).sum();
        Self {
            points: errors.len(),
            rms: (squares / errors.len().max(1) as f64).sqrt(),
            worst: errors.iter().fold(0.0, |worst, e| e.abs().max(worst)),
        }
    }
}

impl LeftOut {
    pub(super) fn measure(family: Family, points: &[&GridPoint]) -> Result<Self, SynthError> {
        let mut found = vec![];
        for (at, left_out) in points.iter().enumerate() {
            let others = [&points[..at], &points[at + 1..]].concat();
            let work = Work::of(&left_out.activity);
            let formulas = Formulas::fit(family, &others)?;
            let estimate = formulas.at(&left_out.config()?, work);
            found.push(PointErrors::new(left_out, &estimate));
        }
        let spread = |of: fn(&PointErrors) -> f64| Spread::new(found.iter().map(of));
        Ok(Self {
            area: spread(|e| e.area),
            period: spread(|e| e.period),
            zero_delay: spread(|e| e.zero_delay),
            with_glitches: spread(|e| e.with_glitches),
            leakage: spread(|e| e.leakage),
            points: found,
        })
    }
}
